// Light, dark, or as the system says.
export const themes = ['system', 'light', 'dark'] as const;
export type Theme = (typeof themes)[number];
const keptUnder = 'vacuform.theme';

export function currentTheme(): Theme {
  const kept = localStorage.getItem(keptUnder);
  return themes.find((theme) => theme === kept) ?? 'system';
}

export function applyTheme(theme: Theme = currentTheme()): void {
  localStorage.setItem(keptUnder, theme);
  if (theme === 'system') delete document.documentElement.dataset['theme'];
  else document.documentElement.dataset['theme'] = theme;
}

// Whether the page is dark now.
export const isDark = (): boolean =>
  currentTheme() === 'dark' || (currentTheme() === 'system' && matchMedia('(prefers-color-scheme: dark)').matches);
