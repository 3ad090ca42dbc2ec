/** Differences from the parent as a table; the viewer shows the parent's bodies as glass. */
import { degrees, percent, significant } from '../format';
import { Badge, Table, type Tone } from '../ui/parts';
import { type Difference, differences, metricChanges } from './difference';
import type { SceneDocument } from './documents';

const TONES: Record<Difference['what'], Tone> = { added: 'good', removed: 'bad', changed: 'busy', moved: 'busy', same: 'plain' };

export function DifferencePanel({
  parent,
  child,
  ghosts,
  onGhosts,
  onSelect,
}: {
  parent: SceneDocument;
  child: SceneDocument;
  ghosts: boolean;
  onGhosts: (on: boolean) => void;
  onSelect: (name: string) => void;
}) {
  const rows = differences(parent, child);
  const metrics = metricChanges(parent.metrics, child.metrics);
  const mm = (value: number) => (Math.abs(value) < 5e-5 ? '0' : significant(value * 1e3, 3));
  const same = rows.filter((row) => row.what === 'same').length;
  const others = (row: Difference) =>
    [
      ['mass', row.massRatio],
      ['size', row.sizeRatio],
      ['friction', row.frictionRatio],
    ]
      .filter(([, ratio]) => Math.abs((ratio as number) - 1) > 1e-6)
      .map(([name, ratio]) => `${name} ${percent(ratio as number)}`)
      .join(', ');
  return (
    <div class="stack">
      <label class="check">
        <input type="checkbox" checked={ghosts} onChange={(event) => onGhosts(event.currentTarget.checked)} />
        Show where the parent has them
      </label>
      <Table caption="Objects that differ from the parent" head={['Object', '', 'x mm', 'y mm', 'z mm', 'yaw', 'other']}>
        {rows
          .filter((row) => row.what !== 'same')
          .map((row) => (
            <tr key={row.name}>
              <td>
                <button type="button" class="quiet" onClick={() => onSelect(row.name)}>
                  {row.name}
                </button>
              </td>
              <td>
                <Badge tone={TONES[row.what]}>{row.what}</Badge>
              </td>
              <td class="number">{mm(row.dx)}</td>
              <td class="number">{mm(row.dy)}</td>
              <td class="number">{mm(row.dz)}</td>
              <td class="number">{row.dyaw === null ? '–' : degrees(Math.abs(row.dyaw) < 1e-4 ? 0 : row.dyaw)}</td>
              <td class="number">{others(row)}</td>
            </tr>
          ))}
      </Table>
      <p class="hint">
        {same} objects are the same.{' '}
        {metrics.length
          ? metrics.map((change) => `${change.name} ${percent(change.before)} → ${percent(change.after)}`).join(', ')
          : 'All metrics are equal.'}
      </p>
    </div>
  );
}
