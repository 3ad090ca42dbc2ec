/** The schema of the options of a scene, as `GET /settings/schema` describes them. */

/** The part of JSON schema that the form knows. */
export interface Schema {
  type?: string | string[];
  title?: string;
  description?: string;
  /** Unit of the number, in words. */
  unit?: string;
  default?: unknown;
  examples?: unknown[];
  enum?: unknown[];
  minimum?: number;
  maximum?: number;
  properties?: Record<string, Schema>;
  anyOf?: Schema[];
  oneOf?: Schema[];
  items?: Schema;
  $ref?: string;
  $defs?: Record<string, Schema>;
}

/** The options in the schema of a request. */
export function optionsSchema(request: Schema): Schema {
  const $defs = request.$defs ?? {};
  return { ...$defs.Options, $defs };
}

/** The schema without references and without the alternative null. */
export function resolved(schema: Schema, root: Schema): Schema {
  if (schema.$ref) {
    const { $ref, ...rest } = schema;
    const name = $ref.split('/').pop()!;
    return { ...resolved(root.$defs?.[name] ?? {}, root), ...rest };
  }
  const choices = schema.anyOf ?? schema.oneOf;
  const real = choices?.filter((choice) => choice.type !== 'null');
  if (choices && real?.length === 1) {
    const { anyOf: _, oneOf: __, ...rest } = schema;
    return { ...resolved(real[0]!, root), ...rest };
  }
  return schema;
}

export type Control = 'number' | 'integer' | 'boolean' | 'choice' | 'text' | 'none';

/** How a value of the schema is asked for; `none` for objects and lists, which the form leaves to programs. */
export function controlOf(schema: Schema): Control {
  if (schema.enum) return 'choice';
  const types = [schema.type ?? []].flat().filter((type) => type !== 'null');
  if (types.length !== 1) return 'none';
  switch (types[0]) {
    case 'integer':
      return 'integer';
    case 'number':
      return 'number';
    case 'boolean':
      return 'boolean';
    case 'string':
      return 'text';
    default:
      return 'none';
  }
}
