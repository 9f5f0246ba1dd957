// How long a search takes on this machine, before it begins.

const KEPT = "driftform-pace";
// Measured on two cores of 2.6 GHz, s of one processor: a flight of the search, one under disturbed conditions, and the
// processes that begin. Among bends and junctions a flight in ten rests in a corner until its time is up.
const COSTS = { straight: { flight: 0.16, disturbed: 0.04 }, parted: { flight: 4, disturbed: 0.6 } };
const START = 12;
// The junctions whose flow comes with driftform: the branch over the bore, and the angle in degrees.
const SOLVED = [[0.5, 60], [0.5, 90], [1, 45], [1, 60], [1, 90], [0.25, 90], [0.7, 45], [0.7, 60], [0.7, 90]];

const kind = (isParted) => (isParted ? "parted" : "straight");

function readPace() {
  try { return JSON.parse(localStorage.getItem(KEPT)) ?? {}; } catch { return {}; }
}

// What searches of a kind took on this machine, over what was expected by the measurements above.
function findPace(isParted) {
  const pace = readPace()[kind(isParted)];
  return pace > 0.05 && pace < 50 ? pace : 1;
}

// Remembers how long a search took that was to take `expected`, s.
export function learnTime(isParted, expected, seconds) {
  localStorage.setItem(KEPT, JSON.stringify({ ...readPace(), [kind(isParted)]: (findPace(isParted) * seconds) / expected }));
}

const way = ({ points: [a, b] }) => { const off = b.map((v, i) => v - a[i]); return off.map((v) => v / Math.hypot(...off)); };

// Whether the flow in the junction of a branch does not come with driftform.
function isUnsolved(branch, axes) {
  const run = axes.find(({ part, branch: isBranch }) => part === branch.part && !isBranch);
  const ratio = branch.radii[0] / run.radii[0];
  const angle = (180 / Math.PI) * Math.acos(Math.min(1, way(branch).reduce((sum, v, i) => sum + v * way(run)[i], 0)));
  return !SOLVED.some(([size, at]) => Math.abs(size - ratio) < 1e-4 && Math.abs(angle - at) < 0.01);
}

// Returns the seconds, and whether the flow in a junction is to be solved before that.
export function expectTime({ isParted, evaluations, targets, robustness: { conditions, finalists, checks }, axes }) {
  const { flight, disturbed } = COSTS[kind(isParted)];
  const flights = conditions ? targets * (finalists * conditions + 4 * checks) : 0;
  const seconds = START + (evaluations * flight + flights * disturbed) / Math.max(1, navigator.hardwareConcurrency);
  return { seconds: seconds * findPace(isParted), needsSolving: axes.some((axis) => axis.branch && isUnsolved(axis, axes)) };
}
