/** Short messages at the edge of the page, which programs for the blind read out. */
import { signal } from '@preact/signals';

interface Announcement {
  id: number;
  text: string;
  tone: 'plain' | 'bad';
}

const announcements = signal<Announcement[]>([]);
let next = 0;

/** Shows a sentence for some seconds. */
export function announce(text: string, tone: 'plain' | 'bad' = 'plain'): void {
  const id = next++;
  announcements.value = [...announcements.value.slice(-2), { id, text, tone }];
  const dismiss = () => {
    announcements.value = announcements.value.filter((one) => one.id !== id);
  };
  setTimeout(dismiss, tone === 'bad' ? 9000 : 4000);
}

export function Announcements() {
  return (
    <div class="announcements" role="status" aria-live="polite">
      {announcements.value.map((one) => (
        <p key={one.id} class={one.tone}>
          {one.text}
        </p>
      ))}
    </div>
  );
}
