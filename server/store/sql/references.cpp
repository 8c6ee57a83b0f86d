// A reference belongs to one head. Whose it is, and how it is corrected.
#include <nlohmann/json.hpp>

#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

Result<void> reference_is_free(Database& db, const std::string& owner, const std::string& reference,
                               const std::string& scan_sha256, const std::string& but) {
  if (reference.empty()) return {};
  Query query(db,
              "SELECT max(job.id), sum(CASE WHEN input.blob=?1 THEN 1 ELSE 0 END)"
              " FROM job JOIN input ON input.job=job.id AND input.name='scan'"
              " WHERE job.owner=?2 AND job.reference=?3 AND job.reference<>'' AND job.id<>?4"
              " AND job.state IN ('queued', 'running', 'succeeded')",
              scan_sha256, owner, reference, but);
  VACUFORM_CHECK(query.row());
  if (query.null(0) || query.integer(1) > 0) return {};
  return fail(Code::conflict, "the reference belongs to another head, that of job " + query.text(0),
              "reference",
              "give this head its own reference; if it is a new scan of the same patient, send rescan=true");
}

// Two submissions at once see each other.
Result<void> claim_reference(Database& db, const std::string& owner, const std::string& reference,
                             const std::string& scan_sha256, const std::string& but) {
  if (reference.empty()) return {};
  VACUFORM_CHECK(db.take_turns("reference " + owner + "/" + reference));
  return reference_is_free(db, owner, reference, scan_sha256, but);
}

}  // namespace

Result<void> SqlStore::check_reference(const std::string& owner, const std::string& reference,
                                       const std::string& scan_sha256, const std::string& but) {
  return read([&](Database& db) { return reference_is_free(db, owner, reference, scan_sha256, but); });
}

Result<void> SqlStore::claim_reference_of(Database& db, const NewJob& job, const std::vector<Blob>& blobs) {
  if (job.rescan) return {};
  for (std::size_t i = 0; i < blobs.size(); ++i)
    if (job.inputs[i].name == "scan")
      return claim_reference(db, job.owner, job.reference, blobs[i].sha256, {});
  return {};
}

Result<Job> SqlStore::set_reference(const std::string& id, const NewReference& reference,
                                    const JobGuard& allowed) {
  return write([&](Transaction& tx) -> Result<Job> {
    VACUFORM_TRY(row, find_row(tx.db, id, Lock::yes, Detail::full));
    Job& job = row.job;
    if (allowed && !allowed(job)) return fail(Code::conflict, "the job has changed", id, "look at it again");
    if (reference.text == job.reference) return std::move(job);
    const Input* scan = job.input("scan");
    if (scan && !reference.rescan)
      VACUFORM_CHECK(claim_reference(tx.db, job.owner, reference.text, scan->blob.sha256, id));
    nlohmann::ordered_json changes = nlohmann::ordered_json::array();
    if (!job.reference_changes.empty()) changes = nlohmann::ordered_json::parse(job.reference_changes);
    if (changes.size() >= most_reference_changes)
      return fail(Code::conflict, "the reference was changed " + std::to_string(changes.size()) + " times",
                  id, "start the job again with the right reference");
    changes.push_back({{"time", options_.clock()},
                       {"owner", reference.owner},
                       {"token", reference.token},
                       {"old", job.reference},
                       {"new", reference.text},
                       {"rescan", reference.rescan}});
    job.reference = reference.text;
    job.reference_changes = changes.dump();
    VACUFORM_CHECK(Query(tx.db, "UPDATE job SET reference=?, reference_changes=? WHERE id=?", job.reference,
                         job.reference_changes, id)
                       .run());
    VACUFORM_CHECK(save(tx, row));
    VACUFORM_CHECK(add_line(tx.db, id, "reference changed"));
    return std::move(job);
  });
}

}  // namespace vacuform
