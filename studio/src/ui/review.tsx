/** Accept, reject and note, with keys. */
import { useState } from 'preact/hooks';
import type { Scene } from '../api/types';
import { useShortcuts } from '../keys';
import { type Decision, label, NOTE, REVIEW } from '../review';
import { may } from '../session';
import { announce } from './announce';

export function Review({ scene, onChange }: { scene: Scene; onChange: () => void }) {
  const [busy, setBusy] = useState(false);
  const decision = scene.labels[REVIEW];
  const set = async (labels: Record<string, string | null>) => {
    if (!may('submit')) return;
    setBusy(true);
    try {
      await label(scene.id, labels);
      onChange();
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
    setBusy(false);
  };
  const decide = (wanted: Decision) => void set({ [REVIEW]: decision === wanted ? null : wanted });
  const note = () => {
    const text = prompt('Note about this scene', scene.labels[NOTE] ?? '');
    if (text !== null) void set({ [NOTE]: text.trim() || null });
  };
  useShortcuts(
    [
      { key: 'a', what: 'Accept', run: () => decide('accept') },
      { key: 'r', what: 'Reject', run: () => decide('reject') },
      { key: 'o', what: 'Write a note', run: note },
    ],
    [scene.id, decision, scene.labels[NOTE]],
  );
  return (
    <span class="row review" role="group" aria-label="Review">
      <button type="button" aria-pressed={decision === 'accept'} disabled={busy || !may('submit')} onClick={() => decide('accept')}>
        Accept
      </button>
      <button type="button" aria-pressed={decision === 'reject'} disabled={busy || !may('submit')} onClick={() => decide('reject')}>
        Reject
      </button>
      <button type="button" class="quiet" onClick={note} disabled={!may('submit')} title={scene.labels[NOTE] ?? ''}>
        {scene.labels[NOTE] ? 'Note ✎' : 'Note'}
      </button>
    </span>
  );
}
