/** Downloads by format, with the lines that load each, and single files of the bundle. */
import { useState } from 'preact/hooks';
import { getJson, request } from '../api/fetch';
import type { BundleFileList, Scene } from '../api/types';
import { bytes } from '../format';
import { useLoad } from '../load';
import { CopyButton, Failed, Waiting } from '../ui/parts';
import { bundleUrl, examples, fileUrl } from './scene_files';

const FORMATS: { format: string; title: string; hint: string; folder: string }[] = [
  { format: 'all', title: 'Everything', hint: 'all formats, report and previews', folder: '' },
  { format: 'mjcf', title: 'MJCF', hint: 'MuJoCo', folder: 'mjcf/' },
  { format: 'usd', title: 'USD', hint: 'Isaac Sim, Newton, Omniverse', folder: 'usd/' },
  { format: 'urdf', title: 'URDF', hint: 'PyBullet, SAPIEN, ROS', folder: 'urdf/' },
  { format: 'sdf', title: 'SDF', hint: 'Gazebo, Drake', folder: 'sdf/' },
  { format: 'glb', title: 'GLB', hint: 'Blender and viewers', folder: 'glb/' },
];

export function Downloads({ scene }: { scene: Scene }) {
  const path = `/scenes/${scene.id}/files${scene.verdict === 'quarantine' ? '?quarantined=true' : ''}`;
  const files = useLoad(path, (signal) => getJson<BundleFileList>(path, signal));
  const readme = useLoad(`${scene.id} readme`, async (signal) => (await request(fileUrl(scene, 'README.md'), { signal })).text());
  const [simulator, setSimulator] = useState('');
  const all = readme.value ? examples(readme.value) : [];
  const shown = all.find((one) => one.title === simulator) ?? all.find((one) => one.title.startsWith('MuJoCo')) ?? all[0];
  return (
    <div class="downloads">
      <ul class="formats">
        {FORMATS.map(({ format, title, hint, folder }) => {
          const size = files.value?.files.filter((file) => file.name.startsWith(folder)).reduce((sum, file) => sum + file.size_bytes, 0);
          return (
            <li key={format}>
              <a class="button" href={bundleUrl(scene, format)} download>
                {title}
              </a>
              <span class="hint">
                {hint}
                {size !== undefined && `; ${bytes(size)} unpacked`}
              </span>
            </li>
          );
        })}
      </ul>
      <p>
        <a href={fileUrl(scene, 'report.html')} target="_blank" rel="noreferrer">
          Report for people
        </a>
        ,{' '}
        <a href={fileUrl(scene, 'report.json')} target="_blank" rel="noreferrer">
          for programs
        </a>
      </p>
      {shown && (
        <>
          <div class="row">
            <label class="inline">
              Load in
              <select value={shown.title} onChange={(event) => setSimulator(event.currentTarget.value)}>
                {all.map((one) => (
                  <option key={one.title}>{one.title}</option>
                ))}
              </select>
            </label>
            <span class="spring" />
            <CopyButton text={shown.code} />
          </div>
          <pre tabIndex={0} aria-label={`Code for ${shown.title}`}>
            {shown.code}
          </pre>
        </>
      )}
      {files.error && <Failed error={files.error} again={files.reload} />}
      {!files.value && files.loading && <Waiting what="the files" />}
      {files.value && (
        <details>
          <summary>All {files.value.files.length} files</summary>
          <ul class="files">
            {files.value.files.map((file) => (
              <li key={file.name}>
                <a href={file.link} target="_blank" rel="noreferrer">
                  {file.name}
                </a>
                <span class="number hint">{bytes(file.size_bytes)}</span>
                <code class="hint" title={`SHA-256 ${file.sha256}`}>
                  {file.sha256.slice(0, 10)}
                </code>
              </li>
            ))}
          </ul>
        </details>
      )}
    </div>
  );
}
