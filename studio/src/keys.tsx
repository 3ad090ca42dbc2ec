/** Keys of the page, and the help that lists them. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { navigate } from './router';
import { Dialog } from './ui/dialog';

export interface Shortcut {
  key: string;
  what: string;
  run: () => void;
}

const shortcuts = signal<Shortcut[]>([]);
export const helpOpen = signal(false);

const EVERYWHERE: Shortcut[] = [
  { key: '?', what: 'Show this help', run: () => (helpOpen.value = true) },
  { key: 'c', what: 'Make a scene', run: () => navigate('/') },
  { key: 'g', what: 'Open the gallery', run: () => navigate('/gallery') },
];

/** Keys that hold while the component is shown. */
export function useShortcuts(list: Shortcut[], inputs: unknown[]): void {
  useEffect(() => {
    shortcuts.value = [...shortcuts.value, ...list];
    return () => {
      shortcuts.value = shortcuts.value.filter((one) => !list.includes(one));
    };
  }, inputs);
}

export function listenToKeys(): void {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const target = event.target as HTMLElement;
    if (target.closest('input:not([type=checkbox]):not([type=range]), textarea, select, dialog[open], [contenteditable]')) return;
    // Controls have keys of their own.
    if (['Enter', ' '].includes(event.key) && target.closest('a, button, summary, input')) return;
    if (event.key.startsWith('Arrow') && target.closest('input')) return;
    const shortcut = [...shortcuts.value]
      .reverse()
      .concat(EVERYWHERE)
      .find((one) => one.key === event.key);
    if (!shortcut) return;
    event.preventDefault();
    shortcut.run();
  });
}

export function Help() {
  if (!helpOpen.value) return null;
  const list = [...shortcuts.value, ...EVERYWHERE];
  return (
    <Dialog title="Keys" onClose={() => (helpOpen.value = false)}>
      <dl class="keys">
        {list.map((one) => (
          <div key={one.key + one.what}>
            <dt>
              <kbd>{one.key === ' ' ? 'Space' : one.key}</kbd>
            </dt>
            <dd>{one.what}</dd>
          </div>
        ))}
      </dl>
      <p class="hint">
        <a href="/openapi.yaml" target="_blank" rel="noreferrer">
          Interface for programs
        </a>
        ,{' '}
        <a href="/studio/licenses.txt" target="_blank" rel="noreferrer">
          licenses of this page
        </a>
      </p>
    </Dialog>
  );
}
