#include "server/store/orphans.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "server/store/blobs/s3/s3_blobs.hpp"
#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

constexpr std::size_t hash_size = 64;

bool is_hexadecimal(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

// Whether a key is that of a blob's object: <sha256>.<generation>.
bool is_object_key(std::string_view key) {
  return key.size() > hash_size && key[hash_size] == '.' && is_hexadecimal(key.substr(0, hash_size)) &&
         is_hexadecimal(key.substr(hash_size + 1));
}

tl::unexpected<Error> orphans_cancelled() {
  return fail(Code::cancelled, "the search for orphans was cancelled");
}

}  // namespace

Result<OrphanReport> BlobStore::orphans(const OrphanSearch&, const std::function<bool()>&) {
  return fail(Code::bad_usage, "there is no bucket: scans and results are files in the data folder", {},
              "use this command with a service that keeps them in an object store");
}

// The row of an object is written before the object. Each page of the list is therefore read before the rows: an object
// of the page without a row is one whose row is deleted or lost, and not one that is about to get its row.
Result<OrphanReport> S3Blobs::orphans(const OrphanSearch& search, const std::function<bool()>& going) {
  const Millis until = options_.clock() - search.older_than;
  OrphanReport report;
  std::vector<std::string> found;
  for (std::string after;;) {
    if (!going()) return orphans_cancelled();
    auto page = client_->list(after);
    if (!page) return tl::make_unexpected(page.error());
    if (page->empty()) break;
    after = page->back().key;
    std::erase_if(*page, [](const S3Listed& object) { return !is_object_key(object.key); });
    if (page->empty()) continue;
    report.objects += static_cast<std::int64_t>(page->size());
    const auto known =
        objects_->keys_between(page->front().key.substr(0, hash_size), page->back().key.substr(0, hash_size));
    if (!known) return tl::make_unexpected(known.error());
    for (const S3Listed& object : *page) {
      if (known->count(object.key) > 0 || !object.stored || *object.stored > until) continue;
      found.push_back(object.key);
      report.bytes += object.bytes;
      report.oldest = std::min(report.oldest.value_or(*object.stored), *object.stored);
    }
  }
  report.orphans = static_cast<std::int64_t>(found.size());
  if (!search.remove) return report;
  const double percent =
      report.objects > 0 ? 100.0 * static_cast<double>(report.orphans) / static_cast<double>(report.objects)
                         : 0;
  if (report.orphans > OrphanSearch::few && percent > search.most) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f", percent);
    return fail(
        Code::conflict,
        std::to_string(report.orphans) + " of " + std::to_string(report.objects) +
            " objects in the bucket are orphans, " + text + " percent: nothing was deleted",
        "--blobs",
        "check that this is the right bucket and the right database; if it is, raise the limit with --most");
  }
  for (const std::string& key : found) {
    if (!going()) return orphans_cancelled();
    if (auto removed = client_->remove(key); !removed) {
      removed.error().what += "; " + std::to_string(report.deleted) + " of " +
                              std::to_string(report.orphans) + " orphans were deleted";
      return tl::make_unexpected(removed.error());
    }
    ++report.deleted;
  }
  return report;
}

Result<std::set<std::string>> SqlStore::keys_between(const std::string& first, const std::string& last) {
  return read([&](Database& db) -> Result<std::set<std::string>> {
    std::set<std::string> keys;
    Query query(db, "SELECT sha256, generation FROM stored_object WHERE sha256>=? AND sha256<=?", first,
                last);
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return keys;
      keys.insert(StoredObject{query.text(0), query.text(1)}.key());
    }
  });
}

}  // namespace vacuform
