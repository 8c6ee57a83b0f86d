// Makes the jobs that most tests look at, in the folder VACUFORM_BROWSER_DATA, which it empties first.
import {mkdirSync, rmSync} from 'node:fs';
import {startFurnished} from './drive.mjs';

const folder = process.env.VACUFORM_BROWSER_DATA;
rmSync(folder, {recursive: true, force: true});
mkdirSync(folder);
const {service} = await startFurnished();
await service.stop();
