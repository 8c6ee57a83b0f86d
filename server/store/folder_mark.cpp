#include "server/store/folder_mark.hpp"

#include <algorithm>
#include <system_error>

#include "api/base/file.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

constexpr const char* file_name = "database-id";

}  // namespace

Result<FolderMark> read_folder_mark(const fs::path& data) {
  const auto text = read_text_file(data / file_name, 64);
  if (!text && text.error().code == Code::not_found) return FolderMark();
  if (!text) return tl::make_unexpected(text.error());
  const auto space = text->find(' '), end = text->find('\n');
  FolderMark mark;
  if (space < end) mark = {text->substr(0, space), text->substr(space + 1, end - space - 1)};
  if ((mark.database == sqlite_name || mark.database == postgresql_name) && !mark.number.empty() &&
      std::ranges::all_of(mark.number, [](char c) { return c >= '0' && c <= '9'; }))
    return mark;
  return fail(Code::corrupt_file, "the file that names the database of this data folder is damaged",
              (data / file_name).string(),
              "if the database is the right one, bind both again with vacuform-server adopt");
}

Result<void> write_folder_mark(const fs::path& data, const FolderMark& mark) {
  return write_text_file(data / file_name, mark.database + " " + mark.number + "\n");
}

bool has_blobs(const fs::path& data) {
  std::error_code error;
  if (!fs::exists(data / "blobs", error)) return bool(error);
  for (fs::recursive_directory_iterator entry(data / "blobs", error), end; !error && entry != end;
       entry.increment(error))
    if (!entry->is_directory(error)) return true;
  return bool(error);
}

}  // namespace vacuform
