// The form of a typed number. Only to show what will be sent: the daemon reads the text, and knows units and ranges.

const number = /^([+-]?(?:\d+(?:[.,]\d+)?|\d+\.|\.\d+)(?:e[+-]?\d+)?)\s*([^\s\d.,].*)?$/i;

const longestShown = 12;  // letters of a refused text

/** `text`: as typed, with a unit. `value`: the number in that unit. `words`: both, with a decimal point. */
export interface Typed { text: string; value: number; unit: string; words: string }

/** A typed number; a text without a unit has the chosen one. Otherwise the reason of a refusal. name: of the field. */
export function typed(name: string, text: string, chosen: string): Typed | { refused: string } {
    const given = text.trim();
    if (given === "") return { refused: `${name}: a number is needed` };
    const [, figures, own] = number.exec(given) ?? [];
    if (figures === undefined) return { refused: `${name}: "${given.slice(0, longestShown)}" is not a number such as 0.5 or 0,5 g` };
    const value = Number(figures.replace(",", ".")), unit = own ?? chosen;
    if (!Number.isFinite(value)) return { refused: `${name}: "${given}" is too large` };
    return { text: own === undefined && chosen !== "" ? `${given} ${chosen}` : given, value, unit, words: `${value} ${unit}`.trim() };
}

/** A whole number from `least`, or the reason of a refusal. */
export function whole(name: string, text: string, least: number): number | { refused: string } {
    const given = text.trim(), count = Number(given);
    return /^\d+$/.test(given) && count >= least ? count : { refused: `${name}: a whole number from ${least}` };
}
