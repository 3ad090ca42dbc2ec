/** Numbers, times and names as people read them. */

const MINUS = '\u2212';

/** A number with so many significant digits and without trailing zeros. */
export function significant(value: number, digits = 3): string {
  if (value === 0) return '0';
  if (!Number.isFinite(value)) return '–';
  const text = Math.abs(value) >= 10 ** digits ? Math.round(value).toString() : String(Number(value.toPrecision(digits)));
  return text.replace('-', MINUS);
}

/** A number with so many decimals, without a sign before zero. */
export function fixed(value: number, decimals: number): string {
  const text = value.toFixed(decimals);
  return (Number(text) === 0 ? text.replace('-', '') : text).replace('-', MINUS);
}

/** A length in meters as micrometers, millimeters, centimeters or meters. */
export function length(meters: number): string {
  const size = Math.abs(meters);
  if (size === 0) return '0 mm';
  if (size < 1e-7) return '< 0.1 µm';
  if (size < 1e-4) return `${significant(meters * 1e6, 2)} µm`;
  if (size < 0.01) return `${significant(meters * 1e3, 2)} mm`;
  if (size < 1) return `${significant(meters * 1e2)} cm`;
  return `${significant(meters)} m`;
}

/** A mass in kilograms as grams or kilograms. */
export function mass(kilograms: number): string {
  return kilograms < 0.9995 ? `${significant(kilograms * 1e3)} g` : `${significant(kilograms)} kg`;
}

export function degrees(radians: number): string {
  const value = (radians * 180) / Math.PI;
  return Math.abs(value) < 1e-3 ? '0°' : `${significant(value)}°`;
}

export function percent(share: number): string {
  return `${significant(Math.round(share * 1000) / 10)} %`;
}

export function bytes(count: number): string {
  if (count < 1000) return `${count} B`;
  if (count < 1e6) return `${significant(count / 1e3)} KB`;
  if (count < 1e9) return `${significant(count / 1e6)} MB`;
  return `${significant(count / 1e9)} GB`;
}

export function duration(milliseconds: number): string {
  if (milliseconds < 1000) return `${Math.round(milliseconds)} ms`;
  const seconds = milliseconds / 1000;
  if (seconds < 60) return `${significant(seconds, seconds < 10 ? 2 : 3)} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
  return `${Math.floor(seconds / 3600)} h ${Math.round((seconds % 3600) / 60)} min`;
}

/** Time since a moment, such as "3 min ago". */
export function ago(moment: string, now: number = Date.now()): string {
  const seconds = (now - Date.parse(moment)) / 1000;
  if (seconds < 5) return 'now';
  if (seconds < 60) return `${Math.floor(seconds)} s ago`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ago`;
  if (seconds < 86400) return `${Math.floor(seconds / 3600)} h ago`;
  return new Date(moment).toLocaleDateString(undefined, { day: 'numeric', month: 'short', year: 'numeric' });
}

export function dateTime(moment: string): string {
  return new Date(moment).toLocaleString(undefined, { dateStyle: 'medium', timeStyle: 'medium' });
}

/** A name of the contract, such as `refine_camera`, as words. */
export function words(name: string): string {
  const text = name.replaceAll('_', ' ');
  return sentence(text.replace(/\busd\b/, 'USD'));
}

/** A sentence of the server with a capital letter. */
export function sentence(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** A count with its noun: "1 object", "3 objects". */
export function count(number: number, noun: string): string {
  return `${number} ${noun}${number === 1 ? '' : 's'}`;
}

/** The last characters of an id, which tell rows apart; ids begin with the time. */
export function short(id: string): string {
  return id.slice(-8);
}
