// Entry point of the operator's page: connects data, views and actions.
import { Abort, listenForAbort } from "./abort";
import { clientName, makeActions, makeReader, takeToken } from "./actions";
import { Alarm } from "./alarm";
import { Connection } from "./connection";
import { byId } from "./dom";
import { LawReader } from "./law";
import { Loop } from "./loop";
import type { Plot } from "./plot";
import { Store } from "./store";
import { Themes } from "./theme";
import { makeCameras } from "./views/cameras";
import { makeCampaign } from "./views/campaign";
import { makeCycle } from "./views/cycle";
import { makeForms } from "./views/forms";
import { makeFriction } from "./views/friction";
import { makeHarmonics } from "./views/harmonics";
import { makeHeader } from "./views/header";
import { makeHealth } from "./views/health";
import { accelerationStrip, makeLive, trackStrip } from "./views/live";
import { makeLog } from "./views/log";
import { makeNumbers } from "./views/numbers";
import { makeOrders } from "./views/orders";
import { makePoints } from "./views/points";
import { makeProgress } from "./views/progress";
import { makeRecordings } from "./views/recordings";
import { makeResults } from "./views/results";
import { makeTargetRegions } from "./views/target_regions";
import { makeTrip } from "./views/trip";
import { makeWaveform } from "./views/waveform";

const token = takeToken(), client = clientName();
const act = makeActions(token, client);
const reader = makeReader(token);
const store = new Store();
const abort = new Abort(act, () => store.state?.session.daemon ?? "");
listenForAbort(abort);

const law = new LawReader(store, reader);
// Relative, as all addresses of the page: a proxy may keep the daemon behind a path.
const socketUrl = new URL(`ws?client=${client}${token ? `&token=${encodeURIComponent(token)}` : ""}`, location.href.replace(/#.*$/, "").replace(/^http/, "ws")).href;
const connection = new Connection(store, socketUrl);
const themes = new Themes(byId("theme", HTMLButtonElement));
const loop = new Loop();
new Alarm(store);
const box = (id: string): HTMLElement => byId(id, HTMLElement);

const waveform = makeWaveform(box("waveform"), store, themes);
const track = makeLive(box("live-track"), store.track, trackStrip, themes);
const acceleration = makeLive(box("live-acceleration"), store.acceleration, accelerationStrip, themes);
const cameras = makeCameras(box("cameras"), box("cameras-card"), store, connection, loop);

loop.add(makeHeader(store, connection, abort), 30);
loop.add(makeTrip(store, reader, themes), 30);
loop.add(makeForms(act, store), 10);
loop.add(makeOrders(act, reader, store), 0.5);
loop.add(makeCampaign(act, reader, store), 5, box("campaign-card"));
loop.add(makeNumbers(store), 10, box("numbers"));
loop.add(makeProgress(store), 10, box("numbers"));
loop.add(waveform.draw, 15, box("waveform-card"));
loop.add(makeHarmonics(box("harmonics"), store, themes), 5, box("harmonics-card"));
loop.add(makeResults(store, reader), 2, box("results-card"));
loop.add(makeRecordings(act, reader), 2, box("recordings-card"));
loop.add(makeCycle(box("cycle-x"), box("cycle-v"), store, themes), 5, box("cycle-card"));
loop.add(makeFriction(box("friction"), store, themes), 2, box("cycle-card"));
loop.add(makePoints(box("points-gamma"), box("key-gamma"), "gamma", "γ, g", store, law, themes), 2, box("gamma-card"));
loop.add(makePoints(box("points-phi"), box("key-phi"), "phi", "φ, degrees", store, law, themes), 2, box("phi-card"));
loop.add(track.draw, 5, box("live-card"));
loop.add(acceleration.draw, 5, box("live-card"));
loop.add(cameras.draw, 15, box("cameras-card"));
loop.add(makeTargetRegions(act, store, cameras.regions), 5, box("cameras-card"));
loop.add(makeHealth(box("jitter"), store, themes), 2, box("health-card"));
loop.add(makeLog(box("log"), store), 5, box("log-card"));
loop.start();

/** Requests streams only while the page is visible, to save work of the daemon. */
function subscribe(): void {
    const streams: [string, Plot | null, number][] = [
        ["waveform", waveform.plot, 15], ["cycle", null, 2], ["track", track.plot, 10],
        ["acceleration", acceleration.plot, 10],
    ];
    for (const [stream, plot, rate] of streams) {
        if (document.hidden) connection.unsubscribe(stream);
        else connection.subscribe(stream, Math.round((plot?.pixels || 400) * devicePixelRatio), rate);
    }
    cameras.subscribe();
}
document.addEventListener("visibilitychange", subscribe);
window.setInterval(subscribe, 1000);  // widths change with the window, visibility with scrolling
subscribe();
