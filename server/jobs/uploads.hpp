// Uploads that arrive in pieces: the rows of the store and the files of sealed_file.hpp brought together, and who is
// writing to which at the moment. A whole upload is stored without the names in it (api/redaction/redaction.hpp); one whose
// file is refused then is deleted.
//
// What a request has sent when it breaks off is kept; while a long one goes on, every 8 MiB are flushed, so that a killed
// server loses no more than these. Memory: the last 16 uploads that were written to keep some 100 KiB each; others read
// themselves through once when they go on.
//
// Where several servers use the store, each flush also puts a piece into the store, from which another server continues.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "server/messages/message.hpp"
#include "server/store/sealed_file.hpp"
#include "server/store/store.hpp"

namespace vacuform {

inline constexpr Millis upload_lifetime = 24LL * 3600 * 1000;

// From any thread.
class Uploads {
 public:
  // Keeps its files in `folder`; what stands there without a row is deleted. Errors: unavailable.
  static Result<std::unique_ptr<Uploads>> open(Store& store, std::filesystem::path folder,
                                               Clock clock = wall_clock);

  // Errors: too_large, bad_usage (no bytes), busy.
  Result<StoredUpload> begin(const std::string& owner, const InputKind& kind, const std::string& extension,
                             std::uint64_t length);
  // How many bytes have come. Errors: locked, while a request sends some.
  Result<std::uint64_t> offset(const StoredUpload& upload);
  // The upload with its blob. Errors: conflict, unless all bytes have come; locked.
  Result<StoredUpload> whole(const StoredUpload& upload);
  // Takes the body's bytes, which begin at `offset`, and gives the new offset; the upload is whole when that is its length.
  // Of a body that must come `whole`, a part is not kept. Errors: locked (another request sends bytes),
  // conflict (offset is not where the upload is), too_large (more than announced), and those of the body.
  Result<std::uint64_t> append(const StoredUpload& upload, std::uint64_t offset, http::Request& request,
                               bool whole);
  Result<void> remove(const std::string& id);
  // Deletes what has expired, and what could not be deleted before. Call it now and then.
  Result<void> collect();

 private:
  struct Writer {
    std::mutex busy;
    std::optional<SealedFile> file;
    int pieces = 0;  // in the store, of the bytes in the file; -1: unknown, since keeping one failed
    std::uint64_t used = 0;
  };
  Uploads(Store& store, std::filesystem::path folder, Clock clock)
      : store_(store), folder_(std::move(folder)), clock_(std::move(clock)) {}
  std::filesystem::path path_of(const std::string& id) const { return folder_ / (id + ".part"); }
  std::shared_ptr<Writer> writer_of(const std::string& id);
  // Opens the writer's file unless it is open and no other server has received bytes since.
  Result<void> open_file(const StoredUpload& upload, Writer& writer);
  Result<void> receive(const StoredUpload& upload, Writer& writer, http::Request& request, bool whole);
  Result<void> flush(const StoredUpload& upload, Writer& writer);
  Result<void> finish(const StoredUpload& upload, Writer& writer);
  // Deletes the files of an upload; collect() tries again what could not be deleted.
  void discard(const std::string& id);

  Store& store_;
  const std::filesystem::path folder_;
  const Clock clock_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Writer>> writers_;
  std::set<std::string> undeleted_;  // ids
  std::uint64_t uses_ = 0;
};

}  // namespace vacuform
