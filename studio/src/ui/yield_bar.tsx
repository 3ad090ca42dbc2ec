/** Shares of the results of many requests as one bar. */
export interface Part {
  name: string;
  number: number;
  tone: 'good' | 'warn' | 'bad' | 'busy' | 'plain';
}

export function YieldBar({ parts, label }: { parts: Part[]; label: string }) {
  const total = parts.reduce((sum, part) => sum + part.number, 0);
  const shown = parts.filter((part) => part.number > 0);
  return (
    <div class="yield">
      <div class="bar-line" role="img" aria-label={`${label}: ${shown.map((part) => `${part.number} ${part.name}`).join(', ') || 'none'}`}>
        {shown.map((part) => (
          <span key={part.name} class={part.tone} style={{ width: `${(part.number / total) * 100}%` }} />
        ))}
      </div>
      <p class="hint number">
        {shown.map((part) => (
          <span key={part.name}>
            <i class={part.tone} aria-hidden="true" /> {part.number} {part.name}
          </span>
        ))}
      </p>
    </div>
  );
}
