/** Fields for the options of a scene, made from their schema. */
import { useState } from 'preact/hooks';
import { controlOf, resolved, type Schema } from '../api/settings';
import { words } from '../format';

export type Values = Record<string, unknown>;

function Field({
  name,
  schema,
  value,
  onChange,
  error,
}: {
  name: string;
  schema: Schema;
  value: unknown;
  onChange: (value: unknown) => void;
  error: string | undefined;
}) {
  const control = controlOf(schema);
  const id = `option-${name}`;
  const common = { id, 'aria-describedby': `${id}-help`, 'aria-invalid': error !== undefined };
  const usual = schema.default ?? schema.examples?.[0];
  const placeholder = usual === undefined || usual === null ? '' : String(usual);
  const text = value === undefined ? '' : String(value);
  return (
    <div class="field">
      <label for={id}>{name.includes('.') ? <code>{name}</code> : words(name)} {schema.unit && <span class="hint">{schema.unit}</span>}</label>
      {control === 'choice' || control === 'boolean' ? (
        <select
          {...common}
          value={text}
          onChange={(event) => {
            const chosen = event.currentTarget.value;
            onChange(chosen === '' ? undefined : control === 'boolean' ? chosen === 'true' : chosen);
          }}
        >
          <option value="">{placeholder ? `usual (${placeholder})` : 'usual'}</option>
          {(control === 'boolean' ? ['true', 'false'] : schema.enum!.filter((one) => one !== null)).map((one) => (
            <option key={String(one)} value={String(one)}>
              {String(one).replaceAll('_', ' ')}
            </option>
          ))}
        </select>
      ) : control === 'text' ? (
        <input
          {...common}
          type="text"
          placeholder={placeholder}
          value={text}
          onInput={(event) => onChange(event.currentTarget.value || undefined)}
        />
      ) : (
        <input
          {...common}
          type="number"
          min={schema.minimum}
          max={schema.maximum}
          step={control === 'integer' ? 1 : 'any'}
          placeholder={placeholder}
          value={text}
          onInput={(event) => {
            const given = event.currentTarget.value;
            onChange(given === '' ? undefined : Number(given));
          }}
        />
      )}
      <p id={`${id}-help`} class="hint">
        {error ? <span class="field-error">{error}</span> : schema.description?.replaceAll('`', '')}
      </p>
    </div>
  );
}

/** The values that differ from the usual ones; settings by name are under `set`. */
export function OptionsForm({
  schema: root,
  values,
  onChange,
  errorAt,
}: {
  schema: Schema;
  values: Values;
  onChange: (values: Values) => void;
  errorAt: (pointer: string) => string | undefined;
}) {
  const [wanted, setWanted] = useState('');
  const change = (all: Values, name: string, value: unknown): Values => {
    const next = { ...all, [name]: value };
    if (value === undefined) delete next[name];
    return next;
  };
  const properties = Object.entries(root.properties ?? {}).map(([name, schema]) => [name, resolved(schema, root)] as const);
  const settings = properties.find(([name]) => name === 'set')?.[1];
  const set = (values.set ?? {}) as Values;
  const found = Object.entries(settings?.properties ?? {})
    .map(([name, schema]) => [name, resolved(schema, root)] as const)
    .filter(([name, schema]) => {
      if (name in set) return true;
      const asked = wanted.trim().toLowerCase();
      return asked !== '' && `${name} ${schema.description ?? ''}`.toLowerCase().includes(asked);
    });
  return (
    <div class="options">
      <div class="fields">
        {properties
          .filter(([, schema]) => controlOf(schema) !== 'none')
          .map(([name, schema]) => (
            <Field
              key={name}
              name={name}
              schema={schema}
              value={values[name]}
              error={errorAt(`/options/${name}`)}
              onChange={(value) => onChange(change(values, name, value))}
            />
          ))}
      </div>
      {settings?.properties && (
        <>
          <label class="search">
            Other settings ({Object.keys(settings.properties).length})
            <input
              type="search"
              placeholder="such as friction, camera, hulls"
              value={wanted}
              onInput={(event) => setWanted(event.currentTarget.value)}
            />
          </label>
          <div class="fields">
            {found.slice(0, 40).map(([name, schema]) => (
              <Field
                key={name}
                name={name}
                schema={schema}
                value={set[name]}
                error={errorAt(`/options/set/${name}`)}
                onChange={(value) => {
                  const next = change(set, name, value === undefined ? undefined : String(value));
                  onChange(change(values, 'set', Object.keys(next).length ? next : undefined));
                }}
              />
            ))}
          </div>
        </>
      )}
    </div>
  );
}
