#include "server/store/sql/copy_store.hpp"

#include <atomic>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "server/store/postgres/postgres_schema.hpp"
#include "server/store/sql/sql_store.hpp"
#include "server/store/sqlite/rows_file.hpp"
#include "server/store/sqlite/sqlite.hpp"

namespace vacuform {

namespace {

namespace fs = std::filesystem;

// The statements of one table; they live as long as the program, as Database::prepared() wants it.
struct TableStatements {
  std::string name, find, select, insert, remove;

  explicit TableStatements(const CopiedTable& table) : name(table.name), insert(insertion(table)) {
    const std::string rows = " FROM " + name + " WHERE " + table.moved;
    find = "SELECT 1" + rows + " LIMIT 1";
    select = std::string("SELECT ") + table.columns + rows;
    remove = "DELETE" + rows;
  }
};

const std::vector<TableStatements>& table_statements() {
  static const std::vector<TableStatements> all(copied_tables().begin(), copied_tables().end());
  return all;
}

Result<std::vector<Blob>> named_blobs(Database& db) {
  std::vector<Blob> blobs;
  Query query(
      db,
      "SELECT blob, max(bytes) FROM (SELECT blob, bytes FROM input UNION SELECT blob, bytes FROM artifact"
      " UNION SELECT blob, bytes FROM scan UNION SELECT blob, bytes FROM upload WHERE blob IS NOT NULL)"
      " GROUP BY blob");
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) return blobs;
    blobs.push_back({query.text(0), static_cast<std::uint64_t>(query.integer(1))});
  }
}

void replace_all(std::string& text, std::string_view old, std::string_view with) {
  for (std::size_t at = text.find(old); at != std::string::npos; at = text.find(old, at + with.size()))
    text.replace(at, old.size(), with);
}

// An error of opening the target names the options of the server; those of the copy have other names.
Error about_target(Error error) {
  for (std::string* text : {&error.where, &error.fix})
    for (const auto& [option, of_target] : {std::pair("--data", "--to"), std::pair("--store", "--to-store"),
                                            std::pair("--blobs", "--to-blobs")})
      replace_all(*text, option, of_target);
  error.what = "the target cannot be opened: " + error.what;
  return error;
}

class StoreCopy {
 public:
  StoreCopy(StorePlace from, StorePlace to, const std::function<bool()>& going,
            const std::function<void(const CopyProgress&)>& progress)
      : from_(std::move(from)), to_(std::move(to)), going_(going), progress_(progress) {
    from_.options.going = to_.options.going = [this] { return undoing_ || going_(); };
  }

  Result<CopyReport> run() {
    VACUFORM_CHECK(open());
    VACUFORM_CHECK(copy());
    auto ended = compare();
    if (ended) ended = revoke_admin_token();
    if (ended) return report_;
    return tl::make_unexpected(undone(ended.error()));
  }

 private:
  Result<void> open() {
    if (!has_store(from_.data)) return no_store(from_.data);
    std::error_code error;
    if (fs::equivalent(from_.data, to_.data, error))
      return fail(Code::bad_usage, "source and target are the same folder", to_.data.string(),
                  "give another folder with --to");
    VACUFORM_TRY(source, open_sql_store(from_.data, from_.options));
    source_ = std::move(source);
    VACUFORM_CHECK(open_target());
    VACUFORM_TRY(table, target_->table_with_rows());
    if (!table) return {};
    return fail(Code::bad_usage, "the target is not empty: it has rows in the table " + *table,
                to_.data.string(),
                "give an empty folder with --to, and an empty database if there is --to-store");
  }

  // The target has no rows after an error.
  Result<void> copy() {
    RowsFile rows(target_->temporary_path());
    VACUFORM_CHECK(source_->copy_rows(rows.path(), going_));
    VACUFORM_CHECK(rows.open());
    VACUFORM_TRY(blobs, named_blobs(rows.db()));
    std::vector<Pin> pins;
    begin("copied", blobs);
    for (const Blob& blob : blobs) {
      auto upload = bytes_of(blob);
      if (upload) {
        VACUFORM_TRY(pin, target_->blobs().put(*upload));
        pins.push_back(std::move(pin));
        copied_.push_back(blob);
        report_.bytes += blob.bytes;
      } else if (is_damage(upload.error())) {
        report_.damaged.push_back(blob.sha256);
      } else {
        return tl::make_unexpected(upload.error());
      }
      ++now_.blobs;
    }
    report_.blobs = static_cast<std::int64_t>(copied_.size());
    begin("added", {});
    return target_->add_rows(rows, [this] {
      progress_(now_);
      ++now_.rows;
      return going_();
    });
  }

  // Opens the target again, so that nothing is trusted because it was written just now.
  Result<void> compare() {
    target_.reset();
    VACUFORM_CHECK(open_target());
    VACUFORM_CHECK(compare_rows());
    begin("compared", copied_);
    for (const Blob& blob : copied_) {
      VACUFORM_CHECK(go_on());
      if (const auto whole = target_->blobs().open(blob.sha256); !whole)
        return is_damage(whole.error())
                   ? fail(Code::internal, "a file differs from that of the source", blob.sha256, "copy again")
                   : tl::make_unexpected(whole.error());
      ++now_.blobs;
      now_.bytes += blob.bytes;
      progress_(now_);
    }
    return {};
  }

  // Its secret stays in the old folder. A server that starts on the target makes another.
  Result<void> revoke_admin_token() {
    VACUFORM_TRY(tokens, target_->tokens());
    for (const Token& token : tokens)
      if (token.file == "admin-token" && !token.revoked) VACUFORM_CHECK(target_->revoke_token(token.id));
    return {};
  }

  Error undone(Error error) {
    undoing_ = true;
    const auto opened = target_ ? Result<void>() : open_target();
    const auto removed = opened ? target_->remove_rows() : opened;
    if (removed) return error;
    return {Code::internal, error.what + "; the copy stays at the target, not compared with the source",
            to_.data.string(), "empty the target and copy again"};
  }

  // Whether an error of reading a blob of the source means that only this blob is lost.
  static bool is_damage(const Error& error) {
    return error.code == Code::gone || error.code == Code::not_found || error.code == Code::unreadable;
  }

  Result<void> open_target() {
    auto target = open_sql_store(to_.data, to_.options);
    if (!target && target.error().code == Code::cancelled) return tl::make_unexpected(target.error());
    if (!target) return tl::make_unexpected(about_target(target.error()));
    target_ = std::move(*target);
    return {};
  }

  void begin(const char* step, const std::vector<Blob>& blobs) {
    now_ = {step, 0, static_cast<std::int64_t>(blobs.size()), 0, 0, 0};
    for (const Blob& blob : blobs) now_.all_bytes += blob.bytes;
  }

  Result<void> go_on() const {
    if (going_()) return {};
    return fail(Code::cancelled, "the copy was cancelled");
  }

  // The bytes of a blob of the source in an upload of the target.
  Result<Upload> bytes_of(const Blob& blob) {
    VACUFORM_CHECK(go_on());
    VACUFORM_TRY(reader, source_->blobs().open(blob.sha256));
    VACUFORM_TRY(upload, target_->upload(Use::submission));
    std::vector<char> piece(1 << 20);
    for (;;) {
      VACUFORM_CHECK(go_on());
      VACUFORM_TRY(n, reader->read_at(upload.bytes(), piece));
      if (n == 0) break;
      VACUFORM_CHECK(upload.write({piece.data(), n}));
      now_.bytes += n;
      progress_(now_);
    }
    if (upload.digest().sha256 == blob.sha256) return upload;
    return fail(Code::gone, "a stored file has changed while it was read", blob.sha256);
  }

  Result<void> compare_rows() {
    RowsFile copy(target_->temporary_path()), rows(target_->temporary_path());
    VACUFORM_CHECK(source_->copy_rows(rows.path(), going_));
    VACUFORM_CHECK(target_->copy_rows(copy.path(), going_));
    VACUFORM_CHECK(rows.open());
    SqliteDatabase& db = rows.db();
    {
      Query attached(db, "ATTACH ? AS copy", copy.path().string());
      VACUFORM_CHECK(attached.run());
    }
    for (const CopiedTable& table : copied_tables()) {
      VACUFORM_CHECK(go_on());
      const auto rows_in = [&](const char* file) {
        return std::string("SELECT ") + table.columns + " FROM " + file + "." + table.name + " WHERE " +
               table.moved;
      };
      const std::string one = rows_in("main"), other = rows_in("copy"),
                        difference = "SELECT count(*) FROM (SELECT * FROM (" + one + " EXCEPT " + other +
                                     ") UNION ALL SELECT * FROM (" + other + " EXCEPT " + one + "))";
      Query query(db, comparisons_.emplace_back(std::make_unique<std::string>(difference))->c_str());
      VACUFORM_CHECK(query.row());
      if (query.integer(0) > 0)
        return fail(Code::internal,
                    std::string("the rows differ from those of the source in the table ") + table.name,
                    to_.data.string(), "copy again");
    }
    Query count(db, "SELECT count(*) FROM copy.job");
    VACUFORM_CHECK(count.row());
    report_.jobs = count.integer(0);
    return {};
  }

  StorePlace from_, to_;
  const std::function<bool()>& going_;
  const std::function<void(const CopyProgress&)>& progress_;
  std::unique_ptr<SqlStore> source_, target_;
  std::vector<Blob> copied_;
  std::vector<std::unique_ptr<std::string>> comparisons_;  // outlive their statements
  CopyProgress now_;
  CopyReport report_;
  std::atomic<bool> undoing_{false};
};

}  // namespace

Result<std::optional<std::string>> SqlStore::table_with_rows() {
  return read([](Database& db) -> Result<std::optional<std::string>> {
    for (const TableStatements& table : table_statements()) {
      Query query(db, table.find.c_str());
      VACUFORM_TRY(found, query.row());
      if (found) return table.name;
    }
    return std::nullopt;
  });
}

Result<void> SqlStore::add_rows(RowsFile& from, const std::function<bool()>& going) {
  return write([&](Transaction& tx) -> Result<void> {
    for (const TableStatements& table : table_statements()) {
      VACUFORM_TRY(insert, tx.db.prepared(table.insert.c_str()));
      VACUFORM_CHECK(from.db().run_for_rows(table.select, *insert, going));
    }
    std::vector<std::string> running;
    {
      Query query(tx.db, "SELECT id FROM job WHERE state IN ('running','cancelling')");
      for (;;) {
        VACUFORM_TRY(more, query.row());
        if (!more) break;
        running.push_back(query.text(0));
      }
    }
    for (const std::string& job : running) VACUFORM_CHECK(lease_times().renew(tx.db, job));
    return {};
  });
}

Result<void> SqlStore::remove_rows() {
  return write([](Transaction& tx) -> Result<void> {
    for (const TableStatements& table : table_statements())
      VACUFORM_CHECK(Query(tx.db, table.remove.c_str()).run());
    return {};
  });
}

Result<CopyReport> copy_store(const StorePlace& from, const StorePlace& to,
                              const std::function<bool()>& going,
                              const std::function<void(const CopyProgress&)>& progress) {
  StoreCopy copy(from, to, going, progress);
  auto report = copy.run();
  if (!report && report.error().code == Code::cancelled)
    return fail(Code::cancelled, "the copy was cancelled; nothing was changed at the target",
                to.data.string(), "run the command again to copy everything");
  return report;
}

}  // namespace vacuform
