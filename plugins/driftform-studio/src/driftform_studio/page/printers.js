// The printers that a design may choose: those that many have, and those that this browser keeps.

const KEPT = "driftform-printers";

// What makers of printers state of the largest part, m.
const KNOWN = {
  "Prusa MK4S": [0.25, 0.21, 0.22], "Bambu Lab X1C, P1S": [0.256, 0.256, 0.256], "Bambu Lab A1 mini": [0.18, 0.18, 0.18], "Creality Ender-3 V3 SE": [0.22, 0.22, 0.25],
};

const isBed = (bed) => Array.isArray(bed) && bed.length === 3 && bed.every((size) => size > 0 && size < 10);

// What was kept, without what is no bed: other pages of this address, or a later version, may have written it.
function readKept() {
  try { return Object.fromEntries(Object.entries(JSON.parse(localStorage.getItem(KEPT)) ?? {}).filter(([, bed]) => isBed(bed))); } catch { return {}; }
}

const write = (printers) => localStorage.setItem(KEPT, JSON.stringify(printers));

// Beds by the names of their printers, m.
export const listPrinters = () => ({ ...KNOWN, ...readKept() });

export const keepPrinter = (name, bed) => write({ ...readKept(), [name]: bed });

export const canForget = (name) => name in readKept();

export function forgetPrinter(name) {
  const { [name]: _, ...others } = readKept();
  write(others);
}
