#include "server/store/blobs/s3/s3_blobs.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "api/base/file.hpp"
#include "api/base/log.hpp"
#include "api/base/secrets.hpp"
#include "api/base/sha256.hpp"

namespace vacuform {

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::uint64_t small_blob = 1 << 20;   // read with one request
constexpr std::uint64_t read_ahead = 4 << 20;   // of a larger one
constexpr std::uint64_t first_piece = 1 << 20;  // where no sequence is to be seen yet
constexpr std::uint64_t most_parts = 10'000;
constexpr std::chrono::seconds deleting(1);            // at a time, in collect_again()
constexpr std::chrono::seconds pause_after_fault(30);  // between deletions
constexpr Millis longest_request = 4 * 3'600'000, between_sweeps = 3'600'000;
constexpr const char* mark_key = "vacuform-store";  // the object that says whose bucket this is

tl::unexpected<Error> damaged(const std::string& sha256) {
  log_event("blob-damaged", {{"blob", sha256}});
  return fail(Code::gone, "a stored file is damaged: its bytes are no longer those that were kept", sha256,
              "restore the bucket from a backup, or send the file again");
}

class MemoryReader : public BlobReader {
 public:
  explicit MemoryReader(std::string bytes) : bytes_(std::move(bytes)) {}
  Result<std::uint64_t> size() const override { return bytes_.size(); }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override {
    if (offset >= bytes_.size()) return std::size_t{0};
    return bytes_.copy(into.data(), into.size(), static_cast<std::size_t>(offset));
  }

 private:
  const std::string bytes_;
};

// Reads an object by ranges, a large one at a time, while the entity tag stays the same.
class ObjectReader : public BlobReader {
 public:
  ObjectReader(std::shared_ptr<S3Client> client, std::shared_ptr<CheckedObjects> checked, StoredObject object,
               std::string etag)
      : client_(std::move(client)),
        checked_(std::move(checked)),
        object_(std::move(object)),
        etag_(std::move(etag)) {}
  Result<std::uint64_t> size() const override { return object_.bytes; }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override {
    if (offset >= object_.bytes || into.empty()) return std::size_t{0};
    const std::lock_guard hold(mutex_);
    if (offset < at_ || offset >= at_ + piece_.size()) VACUFORM_CHECK(fetch(offset));
    return piece_.copy(into.data(), into.size(), static_cast<std::size_t>(offset - at_));
  }
  void invalidate() const override { checked_->forget(object_.key()); }

 private:
  Result<void> fetch(std::uint64_t offset) const {
    const bool goes_on = !piece_.empty() && offset == at_ + piece_.size();
    const std::uint64_t wanted = std::min(goes_on ? read_ahead : first_piece, object_.bytes - offset);
    at_ = offset;
    const auto fetched = client_->get(
        object_.key(), offset, wanted, etag_, [&] { piece_.clear(); },
        [&](std::string_view bytes) {
          piece_ += bytes;
          return piece_.size() <= wanted;
        });
    if (fetched && piece_.size() == wanted) return {};
    piece_.clear();
    if (!fetched) return fetched;
    return fail(Code::unavailable, "the object store gave another part of a file than was asked for");
  }

  const std::shared_ptr<S3Client> client_;
  const std::shared_ptr<CheckedObjects> checked_;
  const StoredObject object_;
  const std::string etag_;
  mutable std::mutex mutex_;
  mutable std::string piece_;
  mutable std::uint64_t at_ = 0;  // of the piece in the object
};

}  // namespace

bool CheckedObjects::good(const std::string& key, const std::string& etag) const {
  const std::lock_guard hold(mutex_);
  const auto found = good_.find(key);
  return found != good_.end() && found->second.etag == etag && SteadyClock::now() < found->second.until;
}

void CheckedObjects::add(const std::string& key, const std::string& etag) {
  if (etag.empty()) return;
  constexpr std::size_t most = 100'000;
  const std::lock_guard hold(mutex_);
  if (good_.size() >= most) good_.clear();
  good_[key] = {etag, SteadyClock::now() + trust_};
}

void CheckedObjects::forget(const std::string& key) {
  const std::lock_guard hold(mutex_);
  good_.erase(key);
}

Result<void> S3Blobs::begin(ObjectTable& objects) {
  objects_ = &objects;
  VACUFORM_CHECK(incoming_.open());
  VACUFORM_CHECK(client_->check());
  return match_bucket();
}

// The rows and the bucket keep the same number, so that neither is used with another.
Result<void> S3Blobs::match_bucket() {
  std::string mark;
  const auto marked = client_->get(
      mark_key, 0, 0, "", [&] { mark.clear(); },
      [&](std::string_view bytes) {
        mark += bytes;
        return mark.size() <= 64;
      });
  if (!marked && marked.error().code != Code::not_found) return marked;
  VACUFORM_TRY(rows, objects_->bucket());
  const std::string number = rows.number ? std::to_string(*rows.number) + "\n" : "";
  if (marked && mark == number) return {};
  if (marked)
    return fail(Code::corrupt_file, "the bucket has the files of another data folder", "--blobs",
                "give the bucket of this data folder, or an empty folder of it: s3://BUCKET/NAME");
  if (rows.number && rows.objects)
    return fail(Code::corrupt_file, "the files of the jobs are in another bucket", "--blobs",
                "give that bucket, or another data folder with --data");
  if (!rows.number && rows.named_blobs)
    return fail(Code::corrupt_file, "the files of the jobs are in the data folder", "--blobs",
                "leave --blobs out, or give an empty data folder with --data");
  const auto fresh = static_cast<std::int64_t>(random_number() & 0x7fffffff);
  if (!rows.number) VACUFORM_CHECK(objects_->remember_bucket(fresh));
  VACUFORM_CHECK(client_->put(mark_key, std::to_string(rows.number.value_or(fresh)) + "\n"));
  return {};
}

Result<Pin> S3Blobs::put(Upload& upload) {
  const Blob& blob = upload.digest();
  Pin pin = pins_->pin(blob.sha256);
  VACUFORM_TRY(there, objects_->live_object(blob.sha256));
  if (there) {
    const auto intact = reader_of(*there);
    if (intact) return pin;
    if (intact.error().code != Code::gone) return tl::make_unexpected(intact.error());
  }
  const StoredObject object{blob.sha256, random_hex(8), blob.bytes};
  VACUFORM_CHECK(objects_->add_uploading(object));
  const auto sent = send(object, upload.path());
  const auto arrived = sent ? objects_->object_arrived(object) : sent;
  if (arrived) return pin;
  (void)objects_->mark_for_deletion(object);  // otherwise the next start does
  return tl::make_unexpected(arrived.error());
}

Result<void> S3Blobs::send(const StoredObject& object, const std::filesystem::path& path) {
  VACUFORM_TRY(file, File::open(path));
  const std::uint64_t part = std::max(options_.part, object.bytes / most_parts + 1);
  const auto etag = object.bytes > options_.parts_above
                        ? client_->put_parts(object.key(), file, object.bytes, part)
                        : client_->put(object.key(), file, object.bytes, object.sha256);
  if (!etag) return tl::make_unexpected(etag.error());
  checked_->add(object.key(), *etag);
  return {};
}

Result<std::unique_ptr<BlobReader>> S3Blobs::open(const std::string& sha256) {
  VACUFORM_TRY(object, objects_->live_object(sha256));
  if (!object) return fail(Code::not_found, "there is no such file", sha256);
  return reader_of(*object);
}

Result<std::unique_ptr<BlobReader>> S3Blobs::reader_of(const StoredObject& object) {
  if (object.bytes <= small_blob) {
    VACUFORM_TRY(bytes, read_small(object));
    return std::make_unique<MemoryReader>(std::move(bytes));
  }
  VACUFORM_TRY(etag, verified(object));
  return std::make_unique<ObjectReader>(client_, checked_, object, std::move(etag));
}

Result<std::string> S3Blobs::read_small(const StoredObject& object) {
  std::string bytes;
  const auto got = client_->get(
      object.key(), 0, 0, "", [&] { bytes.clear(); },
      [&](std::string_view piece) {
        bytes += piece;
        return bytes.size() <= small_blob;
      });
  if (!got && got.error().code != Code::not_found && bytes.size() <= small_blob)
    return tl::make_unexpected(got.error());
  if (!got || text_hash(bytes) != object.sha256) return damaged(object.sha256);
  return bytes;
}

Result<std::string> S3Blobs::verified(const StoredObject& object) {
  const auto found = client_->head(object.key());
  if (!found && found.error().code != Code::not_found) return tl::make_unexpected(found.error());
  if (!found || found->bytes != object.bytes) return damaged(object.sha256);
  if (checked_->good(object.key(), found->etag)) return found->etag;
  return read_whole(object, found->etag, {});
}

Result<std::string> S3Blobs::read_whole(const StoredObject& object, const std::string& etag,
                                        const CheckGoing& going) {
  Sha256 hash;
  bool cancelled = false;
  const auto got = client_->get(
      object.key(), 0, 0, etag, [&] { hash = Sha256(); },
      [&](std::string_view piece) {
        hash.add(piece);
        cancelled = going && !going(piece.size());
        return !cancelled;
      });
  if (cancelled) return fail(Code::cancelled, "the check was cancelled");
  if (!got && got.error().code != Code::gone) return tl::make_unexpected(got.error());
  if (!got || hash.hex() != object.sha256) return damaged(object.sha256);
  checked_->add(object.key(), etag);
  return etag;
}

Result<void> S3Blobs::check(const std::string& sha256, bool read, const CheckGoing& going) {
  VACUFORM_TRY(object, objects_->live_object(sha256));
  if (!object) return fail(Code::not_found, "there is no such file", sha256);
  const auto found = client_->head(object->key());
  if (!found) return tl::make_unexpected(found.error());
  if (found->bytes != object->bytes) return damaged(sha256);
  if (read) VACUFORM_CHECK(read_whole(*object, found->etag, going));
  return {};
}

Result<void> S3Blobs::set_in_quarantine(const std::string& sha256) {
  return fail(Code::bad_usage, "files in an object store have no quarantine", sha256,
              "move the object with the tools of the object store");
}

Result<void> S3Blobs::copy(const std::string& sha256, const std::filesystem::path& blobs) {
  VACUFORM_TRY(object, objects_->live_object(sha256));
  if (!object) return fail(Code::not_found, "there is no such file", sha256);
  const std::filesystem::path to = blobs / sha256.substr(0, 2) / sha256;
  VACUFORM_CHECK(make_directory(to.parent_path()));
  File file;
  Sha256 hash;
  Result<void> written;
  const auto got = client_->get(
      object->key(), 0, 0, "",
      [&] {
        (void)delete_file(to);
        hash = Sha256();
        written = {};
        if (auto created = File::create(to); created)
          file = std::move(*created);
        else
          written = tl::make_unexpected(created.error());
      },
      [&](std::string_view piece) {
        hash.add(piece);
        if (written) written = file.write(piece);
        return written.has_value();
      });
  if (!written)
    return fail(Code::unavailable, "copying a stored file failed: " + written.error().what, to.string(),
                "check that there is room on the disk");
  if (got && hash.hex() == sha256) {
    VACUFORM_CHECK(file.sync());
    return sync_directory(to.parent_path());
  }
  (void)delete_file(to);
  if (!got && got.error().code != Code::not_found) return got;
  return damaged(sha256);
}

void S3Blobs::collect(const std::string& sha256, const Named& named) {
  const bool free = pins_->begin_deletion(sha256);
  const auto marked = free ? mark_if_unwanted(sha256, named) : Result<void>();
  if (free) pins_->deleted(sha256);
  if (free && marked) return;
  const std::lock_guard hold(mutex_);
  if (later_.insert(sha256).second && !marked)
    log_event("file-not-deleted", {{"blob", sha256}, {"problem", marked.error().what}});
}

Result<void> S3Blobs::mark_if_unwanted(const std::string& sha256, const Named& named) {
  VACUFORM_TRY(used, named(sha256));
  if (used) return {};
  return objects_->mark_if_unnamed(sha256);
}

Result<BlobStore::Unnamed> S3Blobs::sweep(const Named&, int) {
  const std::lock_guard hold(mutex_);
  swept_ = options_.clock();
  VACUFORM_CHECK(objects_->mark_unnamed(options_.alone ? 0 : longest_request));
  return Unnamed();
}

void S3Blobs::collect_again(const Named& named) {
  std::set<std::string> later;
  {
    const std::lock_guard hold(mutex_);
    later.swap(later_);
  }
  for (const std::string& sha256 : later) collect(sha256, named);
  sweep_again();
  delete_marked();
}

// What a crashed server left is deleted by those that run on.
void S3Blobs::sweep_again() {
  if (options_.alone) return;
  const Millis now = options_.clock();
  {
    const std::lock_guard hold(mutex_);
    if (now < swept_ + between_sweeps) return;
    swept_ = now;
  }
  if (const auto swept = objects_->mark_unnamed(longest_request); !swept)
    log_event("store-failed", {{"problem", swept.error().text()}});
}

// Stops at the first fault: the object store is probably away.
void S3Blobs::delete_marked() {
  const auto started = SteadyClock::now();
  {
    const std::lock_guard hold(mutex_);
    if (started < no_deletion_until_) return;
  }
  const auto marked = objects_->marked_until(options_.clock() - options_.grace, 200);
  if (!marked) return;
  for (const StoredObject& object : *marked) {
    if (SteadyClock::now() - started > deleting) return;
    auto deleted = client_->remove(object.key());
    if (deleted && object.bytes > options_.parts_above) deleted = client_->abort_uploads(object.key());
    if (deleted) deleted = objects_->forget(object);
    if (deleted) continue;
    log_event("file-not-deleted", {{"blob", object.sha256}, {"problem", deleted.error().what}});
    const std::lock_guard hold(mutex_);
    no_deletion_until_ = SteadyClock::now() + pause_after_fault;
    return;
  }
}

}  // namespace vacuform
