// The cameras' pictures with marks on tracked targets. Each camera decodes one picture at a time; later ones wait.
import type { Connection } from "../connection";
import { make, setText } from "../dom";
import { fixed } from "../format";
import type { PictureFrame } from "../frames";
import type { Loop } from "../loop";
import type { Camera } from "../protocol";
import type { Store } from "../store";
import { drawGeometry, drawScale, drawTarget, figureWords, isLost, targetWords, type Seen } from "./camera_drawing";
import { RegionLayer } from "./target_regions";

const rate = 10;  // Hz

export class CameraView {
    readonly figure = make("figure");
    readonly regions = new RegionLayer();
    private readonly canvas = make("canvas");
    private readonly caption = make("figcaption");
    private shown: PictureFrame | null = null;
    private decoding = false;
    private readonly found = new Map<number, Seen>();  // by the number of the target's mark

    constructor(private readonly name: string) {
        this.canvas.setAttribute("role", "img");
        this.canvas.setAttribute("aria-label", `Picture of camera ${name} with its tracked targets`);
        this.canvas.width = 640;
        this.canvas.height = 160;
        setText(this.caption, `${name}: no picture yet`);
        const picture = make("div", "picture");
        picture.append(this.canvas, this.regions.element);
        this.figure.append(picture, this.caption);
    }

    get pixels(): number { return Math.round(this.canvas.clientWidth * devicePixelRatio); }

    async show(frame: PictureFrame, camera: Camera | null, limitMetres: unknown): Promise<void> {
        if (frame === this.shown || this.decoding) return;
        this.decoding = true;
        this.shown = frame;
        try {
            const bitmap = await createImageBitmap(new Blob([frame.jpeg], { type: "image/jpeg" }));
            this.paint(bitmap, frame, camera, limitMetres);
            bitmap.close();  // frees its memory without waiting for the garbage collector
        } catch {
            setText(this.caption, `${this.name}: a picture could not be decoded`);
        } finally {
            this.decoding = false;
        }
    }

    private paint(bitmap: ImageBitmap, frame: PictureFrame, camera: Camera | null, limitMetres: unknown): void {
        const { canvas } = this;
        const across = Math.max(1, canvas.clientWidth), zoom = across / bitmap.width, down = bitmap.height * zoom;
        const width = Math.round(across * devicePixelRatio), height = Math.round(down * devicePixelRatio);
        if (canvas.width !== width || canvas.height !== height) {
            canvas.width = width;
            canvas.height = height;
            canvas.style.aspectRatio = `${bitmap.width} / ${bitmap.height}`;
        }
        const ctx = canvas.getContext("2d");
        if (!ctx) return;
        ctx.setTransform(width / across, 0, 0, height / down, 0, 0);
        ctx.drawImage(bitmap, 0, 0, across, down);
        if (camera) drawGeometry(ctx, camera, limitMetres, { width: across, height: down });
        frame.marks.forEach((mark, target) => {
            if (!isLost(mark.kind)) this.found.set(target, { mark, t: frame.t0 });
            const seen = this.found.get(target);
            if (seen) drawTarget(ctx, mark.kind, seen, frame.t0, zoom);
        });
        if (camera) drawScale(ctx, camera, { width: across, height: down });
        const figures = camera ? figureWords(camera) : "";
        const targets = camera?.not_found ? `⚠ ${camera.not_found}; press "Move targets"` : targetWords(frame);
        setText(this.caption, `${this.name}, ${fixed(frame.t0, 1)} s: ${targets}${figures ? `; ${figures}` : ""}`);
    }
}

/** Names of the cameras in the table of losses ("camera:top"), in its order; before the first state "top" and "side". */
export function cameraNames(store: Store): string[] {
    const named = (store.state?.losses ?? []).flatMap(({ stream }) => /^camera:(.+)$/.exec(stream)?.[1] ?? []);
    return named.length ? named.slice(0, store.pictures.length) : ["top", "side"];
}

export function makeCameras(
    list: HTMLElement, card: HTMLElement, store: Store, connection: Connection, loop: Loop,
): { draw: () => void; subscribe: () => void; regions: () => RegionLayer[] } {
    let names: string[] = [];
    let views: CameraView[] = [];
    const rebuild = (wanted: string[]): void => {
        for (const name of names) connection.unsubscribe(`camera:${name}`);
        names = wanted;
        views = names.map((name) => new CameraView(name));
        list.replaceChildren(...views.map((view) => view.figure));
    };
    return {
        draw: () => {
            const wanted = cameraNames(store);
            if (wanted.join() !== names.join()) rebuild(wanted);
            views.forEach((view, k) => {
                const frame = store.pictures[k];
                if (frame) void view.show(frame, store.state?.cameras[k] ?? null, store.state?.limits["edge_m"]);
            });
        },
        regions: () => views.map((view) => view.regions),
        /** Requests pictures only while they are in view, because they need most of the bandwidth. */
        subscribe: () => {
            const watched = !document.hidden && loop.isVisible(card);
            views.forEach((view, k) => {
                const stream = `camera:${names[k]}`;
                if (watched && view.pixels > 0) connection.subscribe(stream, view.pixels, rate);
                else connection.unsubscribe(stream);
            });
        },
    };
}
