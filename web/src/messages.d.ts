// Made by the build; see messages.mjs.
declare module 'messages:keys' {
  const keys: readonly string[];
  export default keys;
}
declare module 'messages:en' {
  const texts: readonly (string | 0)[];  // 0: this language has none
  export default texts;
}
declare module 'messages:de' {
  const texts: readonly (string | 0)[];
  export default texts;
}
