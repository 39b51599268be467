// Asks the server of this page. What it does not answer, or cannot, is asked again after a pause.
const PAUSE = 1000; // ms
const SILENT = "zenvoy view has ended; what is loaded stays.";

let silentSince = null; // when a request got no answer
const failures = new Map(); // by path: when a request failed, and why

// A request that got no good answer, or has to wait. `failure` says why.
class Unanswered extends Error {}

// Ignores an error that `failure` tells anyway.
export function report(error) {
  if (!(error instanceof Unanswered)) throw error;
}

// Why the page does not get what it asks for; empty if it does.
export function failure() {
  return silentSince === null ? [...failures.values()].map(({ why }) => why)[0] ?? "" : SILENT;
}

// Returns the answer, whatever its status.
export async function request(what, options = {}) {
  if (silentSince !== null) {
    if (performance.now() - silentSince < PAUSE) throw new Unanswered(SILENT);
    silentSince = performance.now(); // so that the others wait for what becomes of this one
  }
  try {
    const answer = await fetch(what, options);
    silentSince = null;
    return answer;
  } catch (error) {
    if (!(error instanceof TypeError)) throw error; // fetch has no other error for a broken line
    silentSince = performance.now();
    throw new Unanswered(SILENT);
  }
}

export async function ask(what) {
  const path = what.split("?")[0];
  const failed = failures.get(path);
  if (failed) {
    if (performance.now() - failed.at < PAUSE) throw new Unanswered(failed.why);
    failed.at = performance.now();
  }
  const answer = await request(what);
  if (!answer.ok) {
    const why = `${path}: ${answer.status} ${answer.statusText}`;
    failures.set(path, { at: performance.now(), why });
    throw new Unanswered(why);
  }
  failures.delete(path);
  return answer;
}
