/** Counts by name as bars. */
import { useState } from 'preact/hooks';

export interface BarItem {
  name: string;
  value: number;
}

const SHOWN = 12;

export function Bars({ title, items }: { title: string; items: BarItem[] }) {
  const [all, setAll] = useState(false);
  const most = Math.max(1, ...items.map((item) => item.value));
  return (
    <section class="card bars">
      <h2>{title}</h2>
      <ul>
        {items.slice(0, all ? undefined : SHOWN).map((item) => (
          <li key={item.name}>
            <span>{item.name}</span>
            <span class="lane" aria-hidden="true">
              <span style={{ width: `${(item.value / most) * 100}%` }} />
            </span>
            <span class="number">{item.value}</span>
          </li>
        ))}
      </ul>
      {items.length > SHOWN && (
        <button type="button" class="quiet" onClick={() => setAll(!all)}>
          {all ? 'Fewer' : `${items.length - SHOWN} more`}
        </button>
      )}
    </section>
  );
}
