/** Filters of the gallery: parameters of the page's address, and of the list of scenes. */

export type FilterName = 'q' | 'state' | 'verdict' | 'kind' | 'category' | 'label' | 'min_objects' | 'max_objects' | 'parent' | 'sort';
export type Filter = Partial<Record<FilterName, string>>;

export const FILTERS: { name: FilterName; title: string; facet: boolean }[] = [
  { name: 'q', title: 'Words', facet: false },
  { name: 'verdict', title: 'Verdict', facet: true },
  { name: 'state', title: 'State', facet: true },
  { name: 'kind', title: 'Made from', facet: true },
  { name: 'label', title: 'Label', facet: true },
  { name: 'category', title: 'Category', facet: true },
  { name: 'min_objects', title: 'Objects from', facet: false },
  { name: 'max_objects', title: 'Objects to', facet: false },
  { name: 'parent', title: 'Made from scene', facet: false },
  { name: 'sort', title: 'Order', facet: false },
];

/** The filters in an address; other parameters are left out. */
export function filterOf(query: URLSearchParams): Filter {
  const filter: Filter = {};
  for (const { name } of FILTERS) {
    const value = query.get(name);
    if (value) filter[name] = value;
  }
  return filter;
}

/** Parameters of the request; those with their usual value are left out. */
export function searchOf(filter: Filter): Record<string, string> {
  return Object.fromEntries(Object.entries(filter).filter(([name, value]) => value && !(name === 'sort' && value === 'newest')));
}

export const label = {
  /** Facets write a label as `key=value`, the filter as `key:value`. */
  toFilter(name: string, value: string): string {
    return name === 'label' ? value.replace('=', ':') : value;
  },
};
