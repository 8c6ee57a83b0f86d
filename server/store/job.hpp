// A job as the store keeps it, and as it is given to the store.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "api/job.hpp"
#include "server/store/blob_store.hpp"

namespace vacuform {

struct Input {
  std::string name;  // one of input_kinds
  Blob blob;
  std::string
      extension;  // of the uploaded file's name: "stl"; at most 8 lower-case letters and digits, or none
};

inline constexpr int lowest_priority = -10, highest_priority = 10;

struct StoredArtifact {
  std::string name;  // one of artifact_kinds
  Blob blob;
};

struct Job {
  std::string id;  // 26 characters; later jobs have greater ids
  JobKind kind = JobKind::print;
  JobState state = JobState::queued;
  std::optional<Stage> stage;  // none before a worker has said so
  double stage_progress = 0;   // 0..1 of that stage
  int attempt = 0;             // leases so far
  int priority = 0;            // lowest_priority..highest_priority; see Store::lease()
  Millis created = 0;
  std::optional<Millis> started, ended;     // start of the current attempt
  std::optional<Millis> not_before;         // a queued job rests until then after a fault
  std::optional<Error> error;               // why it failed
  std::optional<int> serious_warnings;      // of its result, once it succeeded and where the worker said so
  std::string settings;                     // JSON text, complete
  std::vector<Input> inputs;                // those that it has, in the order of input_kinds
  std::string request;                      // the id of the request that made it; may be empty
  std::string owner;                        // of the token that made it; empty: made before there were tokens
  std::optional<std::string> derived_from;  // the job whose inputs it shares, which may be deleted since
  std::string reference, note;              // as clean_reference() and clean_note() give them
  std::string reference_changes;          // JSON text: a list of {time, owner, token, old, new}; empty: none
  std::vector<StoredArtifact> artifacts;  // in the order of artifact_kinds
  std::int64_t version = 0;               // grows with everything about the job that anybody can see

  // nullptr when it has none of that name.
  const Input* input(std::string_view name) const;
};

// Another reference for a job that exists.
struct NewReference {
  std::string text;          // as clean_reference() gives it; empty: none
  bool rescan = false;       // as in NewJob
  std::string owner, token;  // who changes it
};

inline constexpr int most_reference_changes = 100;  // of a job

// The reference at a time, and the one that the job was created with.
std::string reference_at(const Job& job, Millis time);
std::string first_reference(const Job& job);

// Brings them into the order of input_kinds.
void sort_inputs(std::vector<Input>& inputs);

// What happened to a job, in its order; ids and words of our own, nothing out of a file.
struct LogLine {
  std::int64_t number;  // from 1
  Millis time;
  std::string text;
};

// A file of a new job: an upload, or a blob that something in the store names already.
struct NewInput {
  std::string name;
  std::variant<Upload, Blob> file;
  std::string extension;
};

struct NewJob {
  std::string settings;
  std::string client_key = {};  // the client's own name for this submission, among the owner's; may be empty
  std::vector<NewInput> inputs = {};  // in any order, each name once
  std::string request = {};
  std::string owner = {};
  int priority = 0;
  std::optional<std::string> derived_from = {};
  JobKind kind = JobKind::print;
  std::string reference = {}, note = {};
  bool rescan = false;  // another scan of the patient whose jobs have this reference, as a person confirmed

  void add(std::string name, std::variant<Upload, Blob> file, std::string extension);
};

}  // namespace vacuform
