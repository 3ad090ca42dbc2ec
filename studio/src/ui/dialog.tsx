/** A dialog over the page; the browser keeps the focus in it and closes it by Escape. */
import type { ComponentChildren } from 'preact';
import { useEffect, useRef } from 'preact/hooks';

export function Dialog({
  title,
  onClose,
  children,
  closable = true,
}: {
  title: string;
  onClose: () => void;
  children: ComponentChildren;
  closable?: boolean;
}) {
  const element = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    element.current?.showModal();
  }, []);
  return (
    <dialog
      ref={element}
      aria-label={title}
      onCancel={(event) => {
        if (!closable) event.preventDefault();
      }}
      onClose={() => {
        // Browsers close a dialog at the second Escape, whatever the page says.
        if (closable) onClose();
        else element.current?.showModal();
      }}
    >
      <header>
        <h2>{title}</h2>
        {closable && (
          <button type="button" class="quiet" onClick={() => element.current?.close()} aria-label="Close">
            ✕
          </button>
        )}
      </header>
      {children}
    </dialog>
  );
}
