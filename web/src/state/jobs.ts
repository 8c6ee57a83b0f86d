// The list of jobs.
export interface JobsState {}

export const initialJobs: JobsState = {};
