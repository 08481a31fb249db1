// How far the run is, and the largest values of a period against their limits.
import { byId, make, setData, setText } from "../dom";
import { duration, number } from "../format";
import type { Gauge, Progress, RunState, State } from "../protocol";
import type { Store } from "../store";

const steps: [RunState[], string][] = [
    [["identifying"], "identify"], [["checking"], "check"], [["ramping"], "ramp"], [["settling"], "settle"], [["running"], "measure"],
];

/** "measurement 2 of 3: 13 of 20 periods; 4.1 s left; 38 periods to the edge limit". Empty at rest. */
export function progressWords(progress: Progress | null, periods: number | null): string {
    if (!progress) return "";
    const of = progress.measurements ? ` of ${progress.measurements}` : "";
    const words = [`measurement ${progress.measurement}${of}: ${progress.periods_done ?? 0} of ${periods ?? "?"} periods`];
    if (progress.waits_for !== null) words.push(`waits: ${progress.waits_for}`);
    if (progress.left_s !== null) words.push(`about ${duration(progress.left_s)} left`);
    if (progress.periods_left !== null) words.push(`${progress.periods_left} periods to the edge limit`);
    return words.join("; ");
}

/** True when the walker will be at the edge before the measurements are complete. */
export function leavesTooEarly(state: Pick<State, "progress" | "drive">): boolean {
    const { progress, drive } = state;
    if (!progress || progress.periods_left === null || progress.left_s === null) return false;
    return progress.periods_left < progress.left_s * (drive.frequency_hz ?? 0);
}

function gaugeWords({ unit, limit, set_point, live }: Gauge): string {
    return `${number(live ?? set_point, 3)} of ${number(limit, 3)} ${unit.replace("^2", "²")}`;
}

/** Shares of the limit, at most 1. */
function share(value: number | null, limit: number | null): number {
    return value === null || !limit ? 0 : Math.min(1, value / limit);
}

class GaugeView {
    readonly box = make("div", "gauge");
    private readonly name = make("span");
    private readonly words = make("span");
    private readonly bar = make("div", "bar-of");
    private readonly live = make("i");
    private readonly mark = make("b");

    constructor() {
        this.bar.setAttribute("role", "meter");
        this.bar.append(this.live, this.mark);
        this.box.append(this.name, this.words, this.bar);
    }

    show(gauge: Gauge): void {
        setText(this.name, gauge.quantity);
        setText(this.words, gaugeWords(gauge));
        this.live.style.width = `${100 * share(gauge.live, gauge.limit)}%`;
        this.mark.style.left = `${100 * share(gauge.set_point, gauge.limit)}%`;
        setData(this.box, "near", String(Math.max(share(gauge.live, gauge.limit), share(gauge.set_point, gauge.limit)) > 0.8));
        this.bar.setAttribute("aria-label", gauge.quantity);
        this.bar.setAttribute("aria-valuemin", "0");
        this.bar.setAttribute("aria-valuemax", String(gauge.limit ?? 0));
        this.bar.setAttribute("aria-valuenow", String(gauge.live ?? 0));
    }
}

export function makeProgress(store: Store): () => void {
    const list = byId("steps", HTMLElement), words = byId("progress", HTMLElement), box = byId("gauges", HTMLElement);
    const items = steps.map(([, name]) => make("li", "", name));
    list.append(...items);
    let views: GaugeView[] = [];
    let seen = -1;
    return () => {
        const { state } = store;
        if (!state || seen === store.stateVersion) return;
        seen = store.stateVersion;
        const now = state.session.to_middle ? -1 : steps.findIndex(([states]) => states.includes(state.session.state));
        items.forEach((item, i) => setData(item, "kind", i === now ? "now" : now > i ? "past" : "to come"));
        const { progress } = state;
        setText(words, progressWords(progress, state.result.periods));
        setData(words, "kind", leavesTooEarly(state) ? "trouble" : "calm");
        if (views.length !== state.gauges.length) {
            views = state.gauges.map(() => new GaugeView());
            box.replaceChildren(...views.map((view) => view.box));
        }
        state.gauges.forEach((gauge, i) => views[i]!.show(gauge));
    };
}
