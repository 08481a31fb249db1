// The table of results: a row a measurement, or repeats averaged. A click on a row takes its set-point into the drive's form.
import type { Reader } from "../actions";
import { byId, make, setHidden, setText } from "../dom";
import { decimalsFor, fixed, unknown, withError } from "../format";
import { degrees, paperG } from "../groups";
import type { Estimate, Repeats, ResultRow, SetPoint } from "../protocol";
import { newestFirst, setPointWords } from "../results";
import type { Store } from "../store";
import { offerSetPoint } from "./drive_form";

const mostRows = 200;

const eachHeads = [
    "time", "set-point", "v_D, mm/s", "D, mm", "η, %", "γ measured, g", "φ measured, °", "ρ measured", "walker", "end", "recording",
];
const meanHeads = ["newest", "set-point", "n", "mean v_D, mm/s", "scatter", "stated", "mean D, mm", "mean η, %"];

/** "14:03:21" for a time of today, else "25 Nov 14:03"; of this computer's clock. */
export function rowTime(time: string | null, now = new Date()): string {
    const at = new Date(time ?? NaN);
    if (Number.isNaN(at.getTime())) return unknown;
    if (at.toDateString() === now.toDateString()) return at.toLocaleTimeString("en-GB");
    const [hours, minutes] = at.toLocaleTimeString("en-GB").split(":");
    return `${at.getDate()} ${at.toLocaleString("en", { month: "short" })} ${hours}:${minutes}`;
}

function inDegrees(phi: Estimate | null): string {
    if (phi === null || phi.value === null) return unknown;
    return withError({ value: degrees(phi.value), sigma: phi.sigma === null ? null : degrees(phi.sigma) });
}

function eachCells(row: ResultRow): string[] {
    return [
        rowTime(row.time), setPointWords(row.asked), withError(row.v_D_mps, 1e3), withError(row.D_m, 1e3), withError(row.efficiency, 100),
        withError(row.gamma_mps2, 1 / paperG), inDegrees(row.phi_rad), withError(row.rho),
        row.v_D_mps === null ? "" : row.steady ? "✓ steady" : "⚠ not steady", row.ended, row.recording ?? "not recorded",
    ];
}

/** Scatter and stated error of one measurement with the decimals of the smaller one. */
function errorCells({ scatter_mps: scatter, stated_mps: stated }: Repeats): [string, string] {
    if (stated === null) return [unknown, unknown];
    const decimals = decimalsFor(1e3 * Math.min(stated, scatter || stated), 2);
    return [scatter === null ? unknown : fixed(1e3 * scatter, decimals), fixed(1e3 * stated, decimals)];
}

interface Line { cells: string[]; asked: SetPoint | null; title: string }

function eachLines(store: Store): Line[] {
    return newestFirst(store.results.values()).slice(0, mostRows).map((row) => ({ cells: eachCells(row), asked: row.asked, title: row.notes }));
}

function meanLines(repeats: readonly Repeats[]): Line[] {
    return repeats.slice(0, mostRows).map((r) => ({
        cells: [
            rowTime(r.newest), setPointWords(r.asked), String(r.count), withError(r.v_D_mps, 1e3), ...errorCells(r), withError(r.D_m, 1e3),
            withError(r.efficiency, 100),
        ],
        asked: r.asked, title: "",
    }));
}

/** The set-point of a line is a button, for those who use the keyboard. */
function rowOf({ cells, asked, title }: Line): HTMLTableRowElement {
    const row = make("tr");
    row.title = title;
    cells.forEach((text, i) => {
        const cell = make(i === 0 ? "th" : "td");
        if (i === 0) cell.setAttribute("scope", "row");
        if (i === 1 && asked !== null) {
            const button = make("button", "link", text);
            button.type = "button";
            cell.append(button);
        } else cell.textContent = text;
        if (text.length > 40 && i > 1) cell.className = "text";
        row.append(cell);
    });
    if (asked !== null) row.addEventListener("click", () => offerSetPoint(asked));
    return row;
}

export function makeResults(store: Store, { save, json }: Reader): () => void {
    const head = byId("results-head", HTMLTableRowElement), body = byId("results-rows", HTMLTableSectionElement);
    const averaged = byId("results-averaged", HTMLInputElement), count = byId("results-count", HTMLElement);
    const csv = byId("results-csv", HTMLButtonElement), trouble = byId("results-trouble", HTMLElement);
    csv.addEventListener("click", () => void save("api/results.csv", "results.csv").then((why) => {
        setText(trouble, why);
        setHidden(trouble, why === "");
    }));
    let shown = "";
    const show = (lines: Line[]): void => {
        head.replaceChildren(...(averaged.checked ? meanHeads : eachHeads).map((text) => {
            const cell = make("th", "", text);
            cell.setAttribute("scope", "col");
            return cell;
        }));
        body.replaceChildren(...lines.map(rowOf));
        csv.disabled = averaged.disabled = store.results.size === 0;
        setHidden(byId("results-scroll", HTMLElement), lines.length === 0);
        setText(count, countWords(store.results.size, lines.length, averaged.checked));
    };
    return () => {
        const now = `${store.resultsVersion} ${averaged.checked}`;
        if (now === shown) return;
        shown = now;
        if (!averaged.checked) return show(eachLines(store));
        void json("api/repeats").then((answer) => {
            if (now !== shown) return;
            if (answer === null) shown = "";  // asked again with the next state
            else show(meanLines((answer as { repeats: Repeats[] }).repeats));
        });
    };
}

function countWords(all: number, shown: number, averaged: boolean): string {
    if (all === 0) return "No measurement yet.";
    const measurements = `${all} measurement${all === 1 ? "" : "s"}`;
    if (averaged) return `${measurements}; the steady ones averaged at ${shown} set-point${shown === 1 ? "" : "s"}; scatter and stated: errors of one measurement, mm/s`;
    return shown < all ? `${shown} newest of ${measurements}; the CSV has all` : measurements;
}
