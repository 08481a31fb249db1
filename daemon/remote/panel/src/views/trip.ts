// The trip: what happened and when, what to do, its recording, the last two seconds before it with the limit, and
// the pictures of the moment.
import type { Reader } from "../actions";
import { byId, setHidden, setText } from "../dom";
import { clockTime } from "../format";
import { decodeFrame } from "../frames";
import { common, dashes, line, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { State, Trip } from "../protocol";
import type { Store } from "../store";
import type { Themes } from "../theme";
import { cameraNames, CameraView } from "./cameras";

const window = 2;          // s before the trip
const afterwards = 0.2;    // s after it; then the curve is kept
const buckets = 400;

/** Causes that concern the walker's place; its position is drawn. For all others the acceleration is. */
const places = new Set(["walker_edge", "tracking_lost", "camera_missing"]);

function sentence(text: string): string {
    return text ? `${text[0]!.toUpperCase()}${text.slice(1)}.` : "";
}

/** `when`: clock time. */
export function tripWords(trip: Trip, when: string): string {
    const words = [`Tripped at ${when}: ${trip.finding}.`, sentence(trip.advice)];
    if (trip.recording !== null) words.push(`Recorded in ${trip.recording}.`);
    return words.filter((part) => part !== "").join(" ");
}

/** The limit in the unit of the plot, as far as it is a line in it: mm of the walker's position, or m/s². */
export function limitLines(state: Pick<State, "walker">, trip: Trip): number[] {
    if (trip.limit === null) return [];
    if (trip.cause === "acceleration") return [-trip.limit, trip.limit];
    const { walker } = state;
    if (trip.cause !== "walker_edge" || !walker || walker.left_m === null || walker.right_m === null || walker.edge_m === null) return [];
    const low = Math.min(walker.left_m, walker.right_m), high = Math.max(walker.left_m, walker.right_m);
    const nearLow = walker.x_m - low < high - walker.x_m;
    const half = (nearLow ? walker.x_m - low : high - walker.x_m) - walker.edge_m;
    const inwards = half + trip.limit * 1e-3;
    return [1e3 * (nearLow ? low + inwards : high - inwards)];
}

/** The cameras' pictures at the trip, which the daemon keeps until it is cleared. */
async function showPictures(list: HTMLElement, store: Store, reader: Reader, count: number): Promise<void> {
    const names = cameraNames(store), found = await Promise.all(Array.from({ length: count }, (_, k) => reader.bytes(`api/trip/pictures/${k}`)));
    const shown = found.flatMap((bytes, k) => {
        const frame = bytes && decodeFrame(bytes);
        return frame?.what === "picture" ? [{ frame, k, view: new CameraView(names[k] ?? `camera ${k + 1}`) }] : [];
    });
    list.replaceChildren(...shown.map(({ view }) => view.figure));
    setHidden(list, shown.length === 0);
    for (const { frame, k, view } of shown) await view.show(frame, store.state?.cameras[k] ?? null, store.state?.limits["edge_m"]);
}

export function makeTrip(store: Store, reader: Reader, themes: Themes): () => void {
    const banner = byId("trip", HTMLElement), text = byId("trip-text", HTMLElement), box = byId("trip-plot", HTMLElement);
    const pictures = byId("trip-pictures", HTMLElement);
    let of: number | null = null, when = "", kept = false, label = "";
    let data: Columns = [];
    let plot: Plot | null = null;

    const keep = (state: State, trip: Trip, at: number): void => {
        const place = places.has(trip.cause), stream = place ? store.track : store.acceleration;
        if (!(stream.newest >= at + afterwards) && (trip.age_s ?? 0) < 2) return;  // more is on its way
        kept = true;
        const channel = place ? 0 : 1;
        const found = stream.envelope(Math.min(at + afterwards, stream.newest), window + afterwards, buckets, place ? 1e3 : 1);
        const times = found[0]!, lines = limitLines(state, trip);
        if (times.length < 2) return;
        label = place ? "x, mm" : "a, m/s²";
        data = [times.map((t) => (t ?? 0) + afterwards), found[2 * channel + 1]!, found[2 * channel + 2]!, ...lines.map((y) => times.map(() => y))];
        setHidden(box, false);
        box.replaceChildren();
        plot = new Plot(box, themes, (theme) => ({
            ...common,
            scales: { x: { time: false, range: [-window, afterwards] } },
            axes: [xAxis(theme, "t, s from the trip"), yAxis(theme, label)],
            series: [{}, line(theme.walker, dashes.solid, 1.5), line(theme.walker, dashes.solid, 1.5),
                ...lines.map(() => line(theme.limit, dashes.dashed, 2))],
            bands: [{ series: [2, 1], fill: `${theme.walker}88` }],
        }));
    };

    return () => {
        const state = store.state, trip = state?.session.trip ?? null;
        setHidden(banner, trip === null);
        if (!state || !trip || trip.t_s === null) {
            of = null;
            setHidden(box, true);
            setHidden(pictures, true);
            return;
        }
        if (of !== trip.t_s) {
            of = trip.t_s;
            when = clockTime(trip.age_s ?? 0);
            kept = false;
            plot = null;
            setHidden(box, true);
            void showPictures(pictures, store, reader, trip.pictures ?? 0);
        }
        setText(text, tripWords(trip, when));
        if (!kept) keep(state, trip, trip.t_s);
        if (plot?.stale) plot.draw(data);
    };
}
