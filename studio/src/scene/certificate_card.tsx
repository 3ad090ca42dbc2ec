/** The certificate: the verdict, its reasons, and each measurement beside its threshold. */
import { percent, sentence } from '../format';
import { Badge } from '../ui/parts';
import { type Check, checksOf } from './certificate';
import type { Report, SceneDocument } from './documents';

export function CertificateCard({
  report,
  document: doc,
  onSelect,
}: {
  report: Report;
  document: SceneDocument;
  onSelect: (name: string) => void;
}) {
  const { metrics } = report;
  return (
    <div class="certificate">
      <p>{report.summary}</p>
      <dl class="metrics">
        {(
          [
            ['Col_O', metrics.col_o, 'Colliding pairs'],
            ['SS', metrics.ss, 'Statically stable'],
            ['DSS', metrics.dss_shipped, 'Dynamically stable, as shipped'],
            ['DSS aligned', metrics.dss_aligned, 'Dynamically stable before settling'],
          ] as const
        ).map(([name, value, title]) => (
          <div key={name} title={title}>
            <dt>{name}</dt>
            <dd class="number">{percent(value)}</dd>
          </div>
        ))}
      </dl>
      <ul class="checks">
        {checksOf(report, doc).map((check) => (
          <Row key={check.title} check={check} onSelect={onSelect} />
        ))}
      </ul>
    </div>
  );
}

/** Why a scene was quarantined, with the bodies that are at fault. */
export function Reasons({ report, onSelect }: { report: Report; onSelect: (name: string) => void }) {
  return (
    <div class="notice warn">
      <ul>
        {report.reasons.map((reason) => (
          <li key={reason.sentence}>
            {sentence(reason.sentence)}.{' '}
            {reason.bodies.map((name) => (
              <button type="button" class="quiet" key={name} onClick={() => onSelect(name)}>
                {name}
              </button>
            ))}
          </li>
        ))}
      </ul>
      {report.collisions.map((pair) => (
        <p key={`${pair.a} ${pair.b}`}>
          {pair.a} is {(pair.depth_m * 1e3).toFixed(1)} mm inside {pair.b}.
        </p>
      ))}
    </div>
  );
}

function Row({ check, onSelect }: { check: Check; onSelect: (name: string) => void }) {
  return (
    <li class="check-row">
      <span class="sign">
        {check.passes === null ? (
          <Badge tone="plain">info</Badge>
        ) : check.passes ? (
          <Badge tone="good">ok</Badge>
        ) : (
          <Badge tone="bad">fails</Badge>
        )}
      </span>
      <div>
        <p class="title">{check.title}</p>
        <p class="values number">
          {check.measured}
          {check.worst && (
            <button type="button" class="quiet" onClick={() => onSelect(check.worst!)}>
              {check.worst}
            </button>
          )}
          <span class="hint">{check.asked}</span>
        </p>
        {check.share !== undefined && check.bound && <Bar share={check.share} bound={check.bound} passes={check.passes} />}
      </div>
    </li>
  );
}

/** A bar of the measurement; the line is the threshold, at two thirds of the bar. */
function Bar({ share, bound, passes }: { share: number; bound: 'most' | 'least'; passes: boolean | null }) {
  const width = Math.min(100, (share * 200) / 3);
  return (
    <div
      class={`bullet ${passes === false ? 'bad' : passes ? 'good' : ''}`}
      role="img"
      aria-label={`${Math.round(share * 100)} % of the threshold, which is the ${bound === 'most' ? 'most' : 'least'} that is allowed`}
    >
      <span class="value" style={{ width: `${Math.max(width, 0.7)}%` }} />
      <span class="limit" />
    </div>
  );
}
