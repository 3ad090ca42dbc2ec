/** The request of a scene as code. */
import { useState } from 'preact/hooks';
import type { Scene } from '../api/types';
import { CopyButton } from '../ui/parts';
import { asCode, type Language } from './as_code';

const LANGUAGES: { id: Language; title: string }[] = [
  { id: 'curl', title: 'curl' },
  { id: 'python', title: 'Python' },
  { id: 'json', title: 'JSON' },
];

export function CodePanel({ scene }: { scene: Scene }) {
  const [language, setLanguage] = useState<Language>('curl');
  const code = asCode(scene, language, location.origin);
  return (
    <div class="stack">
      <p class="hint">The same request with the same seed makes the same bytes.</p>
      <div class="row">
        {LANGUAGES.map((one) => (
          <button type="button" key={one.id} aria-pressed={language === one.id} onClick={() => setLanguage(one.id)}>
            {one.title}
          </button>
        ))}
        <span class="spring" />
        <CopyButton text={code} />
      </div>
      <pre tabIndex={0} aria-label={`Request in ${language}`}>
        {code}
      </pre>
    </div>
  );
}
