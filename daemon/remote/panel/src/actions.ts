// HTTP actions. They do not use the socket, so an abort needs only one successful request.

/** `status`: of HTTP; missing without an answer. */
export type Answer = { ok: true } | { ok: false; error: string; status?: number };
/** daemon: the only one at rest that shall carry out the order. */
export type Actions = (name: string, body?: Record<string, unknown>, patience?: number, daemon?: string) => Promise<Answer>;
export const noAnswer = "no answer from the daemon";

const tokenKey = "shakerd-token", clientKey = "shakerd-client";

/** Name of this tab, by which the daemon knows the holder of control; kept over reloads. */
export function clientName(): string {
    const known = sessionStorage.getItem(clientKey);
    if (known) return known;
    const made = Array.from(crypto.getRandomValues(new Uint8Array(6)), (byte) => (byte % 36).toString(36)).join("");
    sessionStorage.setItem(clientKey, made);
    return made;
}

/** The token of `#token=...`, removed from the address bar and kept for reloads of this tab. */
export function takeToken(): string | null {
    const given = new URLSearchParams(location.hash.slice(1)).get("token");
    if (given) {
        sessionStorage.setItem(tokenKey, given);
        history.replaceState(null, "", location.pathname + location.search);
    }
    return sessionStorage.getItem(tokenKey);
}

async function errorOf(response: Response): Promise<string> {
    const body = (await response.json().catch(() => null)) as { error?: unknown } | null;
    return typeof body?.error === "string" ? body.error : `the daemon answered ${response.status}`;
}

/** What the page reads by HTTP. */
export interface Reader {
    /** Saves an answer as a file of this computer. Returns the reason of a failure, else an empty text. */
    save(path: string, name: string): Promise<string>;
    /** Null when there was no answer. */
    json(path: string): Promise<unknown>;
    /** Null when there was no answer. */
    bytes(path: string): Promise<ArrayBuffer | null>;
    /** A link that the browser can follow. */
    address(path: string): string;
}

export function makeReader(token: string | null): Reader {
    const get = (path: string): Promise<Response> => fetch(path, token ? { headers: { "X-Shaker-Token": token } } : {});
    return {
        save: async (path, name) => {
            try {
                const response = await get(path);
                if (!response.ok) return await errorOf(response);
                saveBlob(await response.blob(), name);
                return "";
            } catch {
                return noAnswer;
            }
        },
        json: async (path) => {
            const response = await get(path).catch(() => null);
            return response?.ok ? await response.json().catch(() => null) : null;
        },
        bytes: async (path) => {
            const response = await get(path).catch(() => null);
            return response?.ok ? await response.arrayBuffer().catch(() => null) : null;
        },
        address: (path) => (token ? `${path}?token=${encodeURIComponent(token)}` : path),
    };
}

export function saveBlob(blob: Blob, name: string): void {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);  // ms, for the browser to begin
}

export function makeActions(token: string | null, client: string): Actions {
    const headers: Record<string, string> = { "Content-Type": "application/json", "X-Shaker-Client": client };
    if (token) headers["X-Shaker-Token"] = token;
    return async (name, body, patience = 10_000, daemon = "") => {
        const limit = new AbortController();
        const timer = setTimeout(() => limit.abort(), patience);  // ms
        try {
            const response = await fetch(`api/${name}`, {
                method: "POST",
                headers: daemon ? { ...headers, "X-Shaker-Daemon": daemon } : headers,
                body: body ? JSON.stringify(body) : null,
                signal: limit.signal,
                keepalive: true,  // an abort is sent even when the page is closed directly after it
            });
            return response.ok ? { ok: true } : { ok: false, error: await errorOf(response), status: response.status };
        } catch {
            return { ok: false, error: noAnswer };
        } finally {
            clearTimeout(timer);
        }
    };
}
