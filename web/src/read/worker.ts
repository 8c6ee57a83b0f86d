// Reads scans in a thread of its own, so that the page stays responsive.
export {};
