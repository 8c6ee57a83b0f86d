import shell from './shell.json';
import jobs from './jobs.json';
import print from './new.json';
import result from './result.json';
import scan from './scan.json';
import job from './job.json';
import settings from './settings.json';
import warnings from './warnings.json';
import admin from './admin.json';
import help from './help.json';

export const messages: Record<string, string> = {
  ...shell, ...jobs, ...print, ...scan, ...job, ...result, ...settings, ...warnings, ...admin, ...help};
