// Scans that were uploaded once, to be used in many jobs. A job keeps what it uses: a scan may be deleted while jobs with it
// wait or run.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "server/store/blob_store.hpp"

namespace vacuform {

struct StoredScan {
  std::string id;  // 26 characters; later scans have greater ids
  std::string owner;
  Millis created = 0;
  Blob blob;
  std::string extension;  // as of an Input
};

struct ScanPage {
  std::vector<StoredScan> scans;    // newest first
  std::optional<std::string> next;  // cursor of the page after this one
};

class ScanTable {
 public:
  virtual ~ScanTable() = default;
  // The same bytes of one owner make one scan, however often they are added. Errors: gone, when nothing names a blob any
  // more that the scan was to share.
  virtual Result<StoredScan> add_scan(const std::string& owner, std::variant<Upload, Blob> file,
                                      const std::string& extension) = 0;
  virtual Result<StoredScan> find_scan(const std::string& id) = 0;  // errors: not_found
  // As list() of jobs.
  virtual Result<ScanPage> list_scans(int limit, const std::string& cursor,
                                      const std::optional<std::string>& owner) = 0;
  virtual Result<void> remove_scan(const std::string& id) = 0;  // errors: not_found
};

}  // namespace vacuform
