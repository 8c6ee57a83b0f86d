// PKWARE, .ZIP File Format Specification (APPNOTE.TXT) 6.3: 4.3.7 local headers, 4.3.12 the central
// directory, 4.3.14 and 4.3.15 its zip64 records, 4.3.16 its end.
#include "server/jobs/zip.hpp"

#include <zlib.h>

#include <algorithm>

#include "api/base/secrets.hpp"

namespace vacuform {

namespace {

constexpr std::uint64_t in_32_bits = 0xffffffff;  // this value itself says: see the zip64 record
constexpr std::uint16_t date = 0x21;              // 1980-01-01: no clock and no time zone in the bytes
constexpr std::size_t most_known = 10'000;

class Record {
 public:
  Record& u16(std::uint64_t value) { return little(value, 2); }
  Record& u32(std::uint64_t value) { return little(value, 4); }
  Record& u64(std::uint64_t value) { return little(value, 8); }
  Record& add(std::string_view bytes) {
    text_ += bytes;
    return *this;
  }
  std::string text() { return std::move(text_); }

 private:
  Record& little(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) text_ += static_cast<char>(value >> (8 * i) & 0xff);
    return *this;
  }
  std::string text_;
};

std::uint64_t or_zip64(std::uint64_t value) { return std::min(value, in_32_bits); }

// What the local header and the central one share, from the flags to the length of the name.
void add_entry(Record& record, const Zip::Entry& entry) {
  record.u16(0).u16(0).u16(0).u16(date).u32(entry.crc).u32(entry.blob.bytes).u32(entry.blob.bytes);
  record.u16(entry.name.size());
}

std::string local_header(const Zip::Entry& entry) {
  Record record;
  record.u32(0x04034b50).u16(20);
  add_entry(record, entry);
  return record.u16(0).add(entry.name).text();
}

std::string central_header(const Zip::Entry& entry, std::uint64_t offset) {
  const bool far = offset >= in_32_bits;
  Record record;
  record.u32(0x02014b50).u16(3 << 8 | 45).u16(far ? 45 : 20);  // made on Unix
  add_entry(record, entry);
  record.u16(far ? 12 : 0).u16(0).u16(0).u16(0).u32(0100644u << 16).u32(or_zip64(offset)).add(entry.name);
  if (far) record.u16(1).u16(8).u64(offset);
  return record.text();
}

std::string directory_end(std::uint64_t entries, std::uint64_t offset, std::uint64_t bytes) {
  Record record;
  if (offset >= in_32_bits) {
    record.u32(0x06064b50).u64(44).u16(3 << 8 | 45).u16(45).u32(0).u32(0).u64(entries).u64(entries);
    record.u64(bytes).u64(offset);
    record.u32(0x07064b50).u32(0).u64(offset + bytes).u32(1);
  }
  record.u32(0x06054b50).u16(0).u16(0).u16(entries).u16(entries).u32(bytes).u32(or_zip64(offset)).u16(0);
  return record.text();
}

Result<std::uint32_t> crc_of(const BlobReader& blob) {
  std::vector<char> piece(256 * 1024);
  uLong crc = ::crc32(0, nullptr, 0);
  for (std::uint64_t offset = 0;;) {
    VACUFORM_TRY(n, blob.read_at(offset, piece));
    if (n == 0) return static_cast<std::uint32_t>(crc);
    crc = ::crc32(crc, reinterpret_cast<const Bytef*>(piece.data()), static_cast<uInt>(n));
    offset += n;
  }
}

}  // namespace

std::string zip_etag(const Job& job) {
  std::string text = "zip 2\n";  // raised with every change of the bytes
  for (const auto& artifact : job.artifacts) text += artifact.name + " " + artifact.blob.sha256 + "\n";
  return text_hash(text);
}

Zip::Zip(std::vector<Entry> entries, Open open) : entries_(std::move(entries)), open_(std::move(open)) {
  std::string directory;
  for (const Entry& entry : entries_) {
    directory += central_header(entry, pieces_.empty() ? 0 : pieces_.back().end);
    add(local_header(entry));
    const std::uint64_t begin = pieces_.back().end;
    pieces_.push_back({begin, begin + entry.blob.bytes, {}, &entry});
  }
  const std::uint64_t begin = pieces_.empty() ? 0 : pieces_.back().end;
  const std::string end = directory_end(entries_.size(), begin, directory.size());
  add(directory + end);
}

void Zip::add(std::string text) {
  const std::uint64_t begin = pieces_.empty() ? 0 : pieces_.back().end, end = begin + text.size();
  pieces_.push_back({begin, end, std::move(text), nullptr});
}

Result<const BlobReader*> Zip::opened(const Entry* entry) const {
  if (open_entry_ == entry) return reader_.get();
  VACUFORM_TRY(reader, open_(entry->blob));
  reader_ = std::move(reader);
  open_entry_ = entry;
  return reader_.get();
}

Result<std::size_t> Zip::read_at(std::uint64_t offset, std::span<char> into) const {
  const auto piece = std::find_if(pieces_.begin(), pieces_.end(),
                                  [&](const Piece& candidate) { return offset < candidate.end; });
  if (piece == pieces_.end()) return 0;
  const std::uint64_t at = offset - piece->begin;
  if (!piece->entry) return piece->text.copy(into.data(), into.size(), static_cast<std::size_t>(at));
  VACUFORM_TRY(blob, opened(piece->entry));
  const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(into.size(), piece->end - offset));
  return blob->read_at(at, into.first(most));
}

std::optional<std::vector<std::uint32_t>> Checksums::known(const Job& job) {
  const std::lock_guard hold(mutex_);
  std::vector<std::uint32_t> all;
  for (const auto& artifact : job.artifacts) {
    const auto found = crc_.find(artifact.blob.sha256);
    if (found == crc_.end()) return std::nullopt;
    all.push_back(found->second);
  }
  return all;
}

Result<std::vector<std::uint32_t>> Checksums::of(Store& store, const Job& job) {
  if (auto all = known(job)) return std::move(*all);
  const std::lock_guard one(reading_);
  if (auto all = known(job)) return std::move(*all);  // by the one before
  std::vector<std::uint32_t> all;
  for (const auto& artifact : job.artifacts) {
    VACUFORM_TRY(reader, store.open(artifact.blob));
    VACUFORM_TRY(crc, crc_of(*reader));
    all.push_back(crc);
    const std::lock_guard hold(mutex_);
    if (crc_.size() >= most_known) crc_.clear();
    crc_[artifact.blob.sha256] = crc;
  }
  return all;
}

}  // namespace vacuform
