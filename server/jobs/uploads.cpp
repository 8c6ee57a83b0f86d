#include "server/jobs/uploads.hpp"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "api/base/log.hpp"
#include "server/jobs/form_file.hpp"
#include "server/store/incoming.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t flush_every = 8 << 20;
constexpr std::size_t most_writers = 16;

tl::unexpected<Error> held(const std::string& id) {
  return fail(Code::locked, "another request is sending bytes of this upload", id,
              "try again when it has ended");
}

// Of a writer: a request that asks for the offset holds the upload for a moment, so this waits for that long.
std::unique_lock<std::mutex> held_soon(std::mutex& busy) {
  std::unique_lock writing(busy, std::try_to_lock);
  for (int tries = 0; !writing && tries < 50; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    writing.try_lock();
  }
  return writing;
}

}  // namespace

Result<std::unique_ptr<Uploads>> Uploads::open(Store& store, fs::path folder, Clock clock) {
  VACUFORM_CHECK(make_directory(folder));
  const bool in_pieces = store.shared();
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const auto upload = store.find_upload(entry.path().stem().string());
    const bool unknown =
        !upload && (upload.error().code == Code::not_found || upload.error().code == Code::gone);
    if (!in_pieces && !unknown) continue;
    if (const auto deleted = delete_file(entry.path()); !deleted)
      log_event("file-not-deleted", {{"folder", "uploads"}, {"problem", deleted.error().what}});
  }
  return std::unique_ptr<Uploads>(new Uploads(store, std::move(folder), std::move(clock)));
}

Result<StoredUpload> Uploads::begin(const std::string& owner, const InputKind& kind,
                                    const std::string& extension, std::uint64_t length) {
  if (length > kind.most_bytes)
    return fail(
        Code::too_large,
        "the " + std::string(kind.name) + " is larger than " + std::to_string(kind.most_bytes >> 20) + " MiB",
        "Upload-Length", "send a smaller file");
  if (length == 0) return fail(Code::bad_usage, "the upload has no bytes", "Upload-Length", "choose a file");
  const Millis now = clock_();
  StoredUpload upload{.id = random_hex(16),
                      .owner = owner,
                      .input = std::string(kind.name),
                      .extension = extension,
                      .key = SealedFile::new_key(),
                      .length = length,
                      .created = now,
                      .expires = now + upload_lifetime};
  VACUFORM_CHECK(store_.add_upload(upload));
  return upload;
}

// The writer of an upload; those that nobody uses go, the longest unused first.
std::shared_ptr<Uploads::Writer> Uploads::writer_of(const std::string& id) {
  const std::lock_guard hold(mutex_);
  auto& writer = writers_[id];
  if (!writer) writer = std::make_shared<Writer>();
  writer->used = ++uses_;
  const auto found = writer;
  while (writers_.size() > most_writers) {
    auto oldest = writers_.end();
    for (auto it = writers_.begin(); it != writers_.end(); ++it)
      if (it->second.use_count() == 1 &&
          (oldest == writers_.end() || it->second->used < oldest->second->used))
        oldest = it;
    if (oldest == writers_.end()) break;
    if (store_.shared() && !delete_file(path_of(oldest->first))) undeleted_.insert(oldest->first);
    writers_.erase(oldest);
  }
  return found;
}

Result<std::uint64_t> Uploads::offset(const StoredUpload& upload) {
  if (upload.blob) return upload.length;
  const auto writer = writer_of(upload.id);
  const std::unique_lock writing(writer->busy, std::try_to_lock);
  if (!writing) return held(upload.id);
  if (upload.pieces > 0) return upload.received;
  VACUFORM_TRY(now, store_.find_upload(upload.id));  // it may have been finished meanwhile
  if (now.blob) return now.length;
  VACUFORM_CHECK(open_file(now, *writer));
  const std::uint64_t bytes = writer->file->bytes();
  // The server may have been killed between the last byte and the row.
  if (bytes == upload.length) VACUFORM_CHECK(finish(now, *writer));
  return bytes;
}

Result<std::uint64_t> Uploads::append(const StoredUpload& upload, std::uint64_t offset,
                                      http::Request& request, bool whole) {
  const auto writer = writer_of(upload.id);
  const auto writing = held_soon(writer->busy);
  if (!writing) return held(upload.id);
  VACUFORM_TRY(now, store_.find_upload(upload.id));  // it may have been finished or removed meanwhile
  if (now.blob)
    return offset == now.length && request.content_length == 0
               ? Result<std::uint64_t>(now.length)
               : fail(Code::conflict, "the upload is complete already", upload.id, "use it");
  VACUFORM_CHECK(open_file(now, *writer));
  SealedFile& file = *writer->file;
  if (offset != file.bytes())
    return fail(Code::conflict,
                "the upload is at " + std::to_string(file.bytes()) + " and not at " + std::to_string(offset),
                "Upload-Offset", "ask for the offset (HEAD) and continue there");
  if (request.content_length > upload.length - offset)
    return fail(Code::too_large, "there are more bytes than the upload's length", "Upload-Length",
                "begin an upload of the right length");
  VACUFORM_CHECK(store_.room_for(request.content_length));
  const auto received = receive(upload, *writer, request, whole);
  if (!received && !file.is_flushed()) {  // only flushed bytes count
    file.drop_unflushed();
    writer->file.reset();
  }
  if (!received) return tl::make_unexpected(received.error());
  const std::uint64_t bytes = file.bytes();
  if (bytes < upload.length) return bytes;
  VACUFORM_CHECK(finish(upload, *writer));
  return bytes;
}

Result<void> Uploads::open_file(const StoredUpload& upload, Writer& writer) {
  if (writer.pieces != upload.pieces) writer.file.reset();
  if (writer.file) return {};
  const fs::path path = path_of(upload.id);
  std::vector<Blob> pieces;
  if (upload.pieces > 0) {
    VACUFORM_TRY(kept, store_.pieces(upload.id));
    pieces = std::move(kept);
  } else if (store_.shared()) {
    VACUFORM_CHECK(delete_file(path));
  }
  auto file = pieces.empty() ? SealedFile::open(path, upload.key)
                             : SealedFile::of_pieces(path, upload.key, pieces.size(),
                                                     [&](std::size_t i) { return store_.open(pieces[i]); });
  if (!file) return tl::make_unexpected(std::move(file.error()));
  writer.file.emplace(std::move(*file));
  writer.pieces = upload.pieces;
  return {};
}

// Makes what has come survive this server.
Result<void> Uploads::flush(const StoredUpload& upload, Writer& writer) {
  SealedFile& file = *writer.file;
  if (file.is_flushed()) return {};
  VACUFORM_CHECK(file.flush());
  if (!store_.shared() || file.bytes() == upload.length) return {};
  const int number = std::exchange(writer.pieces, -1);
  VACUFORM_TRY(piece, store_.upload());
  VACUFORM_CHECK(file.write_piece(piece));
  VACUFORM_CHECK(store_.add_piece(upload.id, number, std::move(piece), file.bytes()));
  writer.pieces = number + 1;
  return {};
}

Result<void> Uploads::receive(const StoredUpload& upload, Writer& writer, http::Request& request,
                              bool whole) {
  SealedFile& file = *writer.file;
  std::uint64_t flushed = file.bytes();
  bool refused = false;
  const auto take = [&](std::string_view piece) -> Result<void> {
    refused = true;
    if (piece.size() > upload.length - file.bytes())
      return fail(Code::too_large, "there are more bytes than the upload's length");
    VACUFORM_CHECK(store_.room_for(piece.size()));
    VACUFORM_CHECK(file.take(piece));
    if (!whole && file.bytes() - flushed >= flush_every) {
      VACUFORM_CHECK(flush(upload, writer));
      flushed = file.bytes();
    }
    refused = false;
    return {};
  };
  const auto read = request.body->read(take);
  if (!refused && (read || !whole)) VACUFORM_CHECK(flush(upload, writer));
  return read;
}

// Stores a whole file without its names. What is refused then is refused for good.
Result<void> Uploads::finish(const StoredUpload& upload, Writer& writer) {
  auto redacted = redacted_upload(store_, *writer.file, upload.input, upload.extension);
  writer.file.reset();
  if (!redacted && is_fault_of_file(redacted.error().code)) {
    VACUFORM_CHECK(store_.remove_upload(upload.id));
    discard(upload.id);
  }
  if (!redacted) return tl::make_unexpected(std::move(redacted.error()));
  VACUFORM_CHECK(store_.finish_upload(upload.id, *std::move(redacted)));
  discard(upload.id);
  return {};
}

Result<StoredUpload> Uploads::whole(const StoredUpload& upload) {
  VACUFORM_TRY(bytes, offset(upload));
  if (bytes < upload.length)
    return fail(Code::conflict,
                "the upload is not complete: " + std::to_string(bytes) + " of " +
                    std::to_string(upload.length) + " bytes have come",
                upload.id, "send the rest first");
  return store_.find_upload(upload.id);
}

Result<void> Uploads::remove(const std::string& id) {
  const auto writer = writer_of(id);
  const auto writing = held_soon(writer->busy);
  if (!writing) return held(id);
  VACUFORM_CHECK(store_.remove_upload(id));
  writer->file.reset();
  discard(id);
  return {};
}

void Uploads::discard(const std::string& id) {
  const auto removed = delete_file(path_of(id));
  const std::lock_guard hold(mutex_);
  if (removed)
    undeleted_.erase(id);
  else if (undeleted_.insert(id).second)
    log_event("file-not-deleted", {{"upload", id}, {"problem", removed.error().what}});
}

Result<void> Uploads::collect() {
  VACUFORM_TRY(ids, store_.expire_uploads());
  {
    const std::lock_guard hold(mutex_);
    ids.insert(ids.end(), undeleted_.begin(), undeleted_.end());
  }
  for (const std::string& id : ids) discard(id);
  return {};
}

}  // namespace vacuform
