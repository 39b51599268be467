// Asks the server of this page. One that does not answer is asked again after a pause.
const PAUSE = 1000; // ms

let silentSince = null; // when the last request got no answer

export class Silent extends Error {
  constructor() {
    super("zenvoy view has ended; what is loaded stays.");
  }
}

export const isSilent = () => silentSince !== null;

// Returns the answer, whatever its status.
export async function request(what, options = {}) {
  if (silentSince !== null && performance.now() - silentSince < PAUSE) throw new Silent();
  try {
    const answer = await fetch(what, options);
    silentSince = null;
    return answer;
  } catch (error) {
    if (!(error instanceof TypeError)) throw error; // fetch has no other error for a broken line
    silentSince = performance.now();
    throw new Silent();
  }
}

export async function ask(what) {
  const answer = await request(what);
  if (!answer.ok) throw new Error(`${what.split("?")[0]}: ${answer.status} ${answer.statusText}`);
  return answer;
}
