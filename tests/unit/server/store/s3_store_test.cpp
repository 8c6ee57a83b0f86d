// The store with its blobs in a real object store, and its rows in either database; and what is so with objects alone.
#include "server/store/blobs/s3/s3_blobs.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <map>

#include "server/store/blobs/files/file_blobs.hpp"
#include "tests/unit/server/store/postgres_server.hpp"
#include "tests/unit/server/store/s3_server.hpp"
#include "tests/unit/server/store/store_fixture.hpp"

namespace vacuform {
namespace {

constexpr Millis hour = 3'600'000;

// One folder of the bucket for each data folder of a test.
std::string folder_of(const fs::path& data) { return data.parent_path().filename().string(); }

StoreOptions with_objects(const fs::path& data, StoreOptions options) {
  options.blobs = S3Server::get().url(folder_of(data));
  options.blobs_credentials = S3Server::get().credentials_file();
  return options;
}

Result<std::unique_ptr<Store>> open_sqlite_and_s3(const fs::path& data, StoreOptions options) {
  return open_store(data, with_objects(data, std::move(options)));
}

Result<std::unique_ptr<Store>> open_postgres_and_s3(const fs::path& data, StoreOptions options) {
  std::string schema = folder_of(data);
  std::replace(schema.begin(), schema.end(), '-', '_');
  options.database = PostgresServer::get().url(schema);
  return open_store(data, with_objects(data, std::move(options)));
}

std::vector<S3Listed> objects_of(const fs::path& data) {
  auto client = S3Server::get().client(folder_of(data));
  const auto listed = client.list("");
  EXPECT_TRUE(listed) << listed.error().text();
  std::vector<S3Listed> objects;
  for (const S3Listed& object : *listed)
    if (object.key != "vacuform-store") objects.push_back(object);
  return objects;
}

std::set<std::string> blob_objects(const fs::path& data) {
  std::set<std::string> hashes;
  for (const S3Listed& object : objects_of(data)) hashes.insert(object.key.substr(0, object.key.find('.')));
  return hashes;
}

void change_object(const fs::path& data, const std::string& sha256, const std::string& bytes) {
  auto client = S3Server::get().client(folder_of(data));
  for (const S3Listed& object : objects_of(data))
    if (object.key.starts_with(sha256)) {
      ASSERT_TRUE(client.put(object.key, bytes));
    }
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(StoreInFilesTest);
INSTANTIATE_TEST_SUITE_P(
    , StoreTest,
    testing::Values(Backend{"SqliteAndS3", open_sqlite_and_s3, blob_objects, change_object, 4 * hour},
                    Backend{"PostgresAndS3", open_postgres_and_s3, blob_objects, change_object, 4 * hour}),
    [](const auto& backend) { return backend.param.name; });

// Blobs as objects, with the rows of a real store, and with small limits.
class S3BlobsTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-objects-" + random_hex(8));
    StoreOptions rows;
    rows.clock = [this] { return now_; };
    store_ = std::move(*open_store(folder_ / "rows", rows));
    blobs_ =
        std::make_unique<S3Blobs>(data(), nullptr, s3_address(S3Server::get().url(folder_of(data()))).value(),
                                  S3Server::get().credentials(), options());
    const auto started = blobs_->begin(table());
    ASSERT_TRUE(started) << started.error().text();
  }
  void TearDown() override {
    blobs_.reset();
    store_.reset();
    fs::remove_all(folder_);
  }

  fs::path data() const { return folder_ / "data"; }
  ObjectTable& table() { return dynamic_cast<ObjectTable&>(*store_); }
  S3Options options() {
    S3Options options;
    options.clock = [this] { return now_; };
    options.grace = hour;
    options.parts_above = 2 << 20;
    options.part = 1 << 20;
    return options;
  }
  static std::string bytes(std::size_t count, char first = 'a') {
    std::string text;
    for (std::size_t i = 0; text.size() < count; ++i) text += std::to_string(i) + first;
    text.resize(count);
    return text;
  }
  Result<Pin> put(const std::string& text) {
    auto upload = blobs_->upload();
    EXPECT_TRUE(upload && upload->write(text));
    return blobs_->put(*upload);
  }
  void collect(const std::string& hash) {
    const auto unwanted = [](const std::string&) { return false; };
    blobs_->collect(hash, unwanted);
    blobs_->collect_again(unwanted);
  }
  static std::string all_of(const BlobReader& reader, std::size_t at_a_time) {
    std::string text, piece(at_a_time, '\0');
    for (;;) {
      const auto n = reader.read_at(text.size(), piece);
      EXPECT_TRUE(n) << n.error().text();
      if (!n || *n == 0) return text;
      text.append(piece, 0, *n);
    }
  }

  fs::path folder_;
  Millis now_ = 1'800'000'000'000;
  std::unique_ptr<Store> store_;
  std::unique_ptr<S3Blobs> blobs_;
};

TEST_F(S3BlobsTest, GivesTheBytesOfBlobsOfEverySize) {
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{1} << 20, (std::size_t{1} << 20) + 1,
        std::size_t{2} << 20, (std::size_t{2} << 20) + 1, std::size_t{7'000'001}}) {
    const std::string text = bytes(size), hash = text_hash(text);
    const auto pin = put(text);
    ASSERT_TRUE(pin) << size << ": " << pin.error().text();
    const auto reader = blobs_->open(hash);
    ASSERT_TRUE(reader) << size << ": " << reader.error().text();
    EXPECT_EQ((*reader)->size().value(), size);
    EXPECT_TRUE(all_of(**reader, 65'536) == text) << size;
    S3Blobs other(folder_ / "other", nullptr, s3_address(S3Server::get().url(folder_of(data()))).value(),
                  S3Server::get().credentials(), options());
    ASSERT_TRUE(other.begin(table()));
    const auto unknown = other.open(hash);  // it reads the blob through before it gives it
    ASSERT_TRUE(unknown) << size << ": " << unknown.error().text();
    EXPECT_TRUE(all_of(**unknown, 1'000'003) == text) << size;
  }
}

TEST_F(S3BlobsTest, GivesAnyRangeOfALargeBlob) {
  const std::string text = bytes(7'000'000);
  ASSERT_TRUE(put(text));
  const auto reader = *blobs_->open(text_hash(text));
  std::string piece(1000, '\0');
  for (const std::uint64_t at : {6'999'999u, 0u, 999'999u, 1'048'575u, 1'048'576u, 5'000'000u, 500u}) {
    const std::size_t wanted = std::min<std::size_t>(1000, text.size() - at);
    std::size_t got = 0;
    while (got < wanted) got += *reader->read_at(at + got, std::span(piece).subspan(got, wanted - got));
    EXPECT_EQ(piece.substr(0, wanted), text.substr(at, wanted)) << at;
  }
  EXPECT_EQ(*reader->read_at(7'000'000, piece), 0u);
  EXPECT_EQ(*reader->read_at(8'000'000, piece), 0u);
}

TEST_F(S3BlobsTest, TheSameBytesAreStoredOnce) {
  const std::string text = bytes(100);
  ASSERT_TRUE(put(text) && put(text));
  EXPECT_EQ(objects_of(data()).size(), 1u);
}

TEST_F(S3BlobsTest, ADownloadUnderWayEndsWellAndTheObjectIsDeletedAfterTheGrace) {
  const std::string text = bytes(7'000'000), hash = text_hash(text);
  ASSERT_TRUE(put(text));
  const auto reader = *blobs_->open(hash);
  collect(hash);
  EXPECT_EQ(blobs_->open(hash).error().code, Code::not_found);
  now_ += hour - 1;
  collect(hash);
  EXPECT_TRUE(all_of(*reader, 65'536) == text);
  now_ += 1;
  collect(hash);
  EXPECT_TRUE(objects_of(data()).empty());
}

// A deletion that comes late cannot hit bytes that were stored again.
TEST_F(S3BlobsTest, BytesThatAreStoredAgainGetAnotherKey) {
  const std::string text = bytes(100), hash = text_hash(text);
  ASSERT_TRUE(put(text));
  const std::string first = objects_of(data()).at(0).key;
  collect(hash);
  ASSERT_TRUE(put(text));
  EXPECT_EQ(objects_of(data()).size(), 2u);
  now_ += hour;
  blobs_->collect_again([](const std::string&) { return true; });
  const auto left = objects_of(data());
  ASSERT_EQ(left.size(), 1u);
  EXPECT_NE(left[0].key, first);
  EXPECT_TRUE(blobs_->open(hash));
}

TEST_F(S3BlobsTest, ALargeObjectThatChangesIsNoticed) {
  const std::string text = bytes(2'000'000), other = bytes(2'000'000, 'b'), hash = text_hash(text);
  ASSERT_TRUE(put(text));
  const auto reader = *blobs_->open(hash);
  std::string piece(1000, '\0');
  EXPECT_TRUE(reader->read_at(0, piece));
  change_object(data(), hash, other);
  EXPECT_EQ(reader->read_at(1'500'000, piece).error().code, Code::gone);
  EXPECT_EQ(blobs_->open(hash).error().code, Code::gone);
  ASSERT_TRUE(put(text));  // repairs it
  EXPECT_TRUE(all_of(**blobs_->open(hash), 65'536) == text);
}

TEST_F(S3BlobsTest, AMissingObjectIsNoticed) {
  for (const std::string& text : {bytes(100), bytes(2'000'000)}) {
    ASSERT_TRUE(put(text));
    auto client = S3Server::get().client(folder_of(data()));
    for (const S3Listed& object : objects_of(data())) ASSERT_TRUE(client.remove(object.key));
    EXPECT_EQ(blobs_->open(text_hash(text)).error().code, Code::gone);
  }
}

TEST_F(S3BlobsTest, WithoutTheObjectStoreNothingIsAcceptedAndNothingIsLost) {
  const std::string before = bytes(2'000'000), during = bytes(100);
  ASSERT_TRUE(put(before));
  S3Server::get().kill();
  const auto started = std::chrono::steady_clock::now();
  EXPECT_EQ(put(during).error().code, Code::unavailable);
  EXPECT_EQ(blobs_->open(text_hash(before)).error().code, Code::unavailable);
  collect(text_hash(during));
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(20));
  S3Server::get().start();
  EXPECT_TRUE(all_of(**blobs_->open(text_hash(before)), 65'536) == before);
  EXPECT_EQ(blobs_->open(text_hash(during)).error().code, Code::not_found);
  EXPECT_TRUE(put(during));
}

// What a crash between the first byte and the last row leaves.
TEST_F(S3BlobsTest, AnObjectThatNeverBecameABlobIsDeletedAfterTheNextStart) {
  const StoredObject half{text_hash("half a scan"), random_hex(8), 11};
  ASSERT_TRUE(table().add_uploading(half));
  ASSERT_TRUE(S3Server::get().client(folder_of(data())).put(half.key(), "half a scan"));
  ASSERT_TRUE(blobs_->sweep([](const std::string&) { return true; }, 30));
  now_ += hour;
  collect(half.sha256);
  EXPECT_TRUE(objects_of(data()).empty());
}

// As if the rows were restored from a backup. now_ is months after the objects were stored.
TEST_F(S3BlobsTest, FindsAndDeletesObjectsWithoutARowAndNothingElse) {
  const auto go_on = [] { return true; };
  auto client = S3Server::get().client(folder_of(data()));
  ASSERT_TRUE(put(bytes(10)) && put(bytes(20)));
  blobs_->collect(text_hash(bytes(20)), [](const std::string&) { return false; });  // marked
  const StoredObject arriving{text_hash("arriving"), random_hex(8), 8};
  ASSERT_TRUE(table().add_uploading(arriving));
  ASSERT_TRUE(client.put(arriving.key(), "arriving"));
  const std::string other_generation = text_hash(bytes(10)) + "." + random_hex(8),
                    unknown = text_hash("unknown") + "." + random_hex(8);
  for (const std::string& orphan : {other_generation, unknown}) ASSERT_TRUE(client.put(orphan, "bytes"));
  const std::vector<std::string> foreign{"notes.txt", text_hash("unknown"), text_hash("unknown") + ".txt",
                                         "other/" + unknown};
  for (const std::string& key : foreign) ASSERT_TRUE(client.put(key, "bytes"));

  OrphanSearch search;
  const auto found = blobs_->orphans(search, go_on);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->objects, 5);
  EXPECT_EQ(found->orphans, 2);
  EXPECT_EQ(found->bytes, 10u);
  EXPECT_EQ(found->deleted, 0);
  EXPECT_LT(std::abs(found->oldest.value_or(0) - wall_clock()), hour);
  EXPECT_EQ(objects_of(data()).size(), 9u);

  search.remove = true;
  search.older_than = now_ - wall_clock() + hour;  // than an hour ago
  EXPECT_EQ(blobs_->orphans(search, go_on)->orphans, 0);
  search.older_than -= 2 * hour;
  EXPECT_EQ(blobs_->orphans(search, [] { return false; }).error().code, Code::cancelled);
  EXPECT_EQ(blobs_->orphans(search, go_on)->deleted, 2);
  std::set<std::string> left;
  for (const S3Listed& object : objects_of(data())) left.insert(object.key);
  EXPECT_EQ(left.size(), 7u);
  EXPECT_EQ(left.count(other_generation) + left.count(unknown), 0u);
  EXPECT_EQ(left.count(arriving.key()), 1u);
  for (const std::string& key : foreign) EXPECT_EQ(left.count(key), 1u) << key;
  EXPECT_TRUE(blobs_->open(text_hash(bytes(10))));
}

TEST_F(S3BlobsTest, RefusesToDeleteManyOrphans) {
  const auto go_on = [] { return true; };
  auto client = S3Server::get().client(folder_of(data()));
  ASSERT_TRUE(put(bytes(10)));
  const auto add_orphan = [&] {
    ASSERT_TRUE(client.put(text_hash(random_hex(8)) + "." + random_hex(8), "bytes"));
  };
  for (int i = 0; i < OrphanSearch::few + 1; ++i) add_orphan();
  OrphanSearch search;
  search.remove = true;
  const auto refused = blobs_->orphans(search, go_on);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::conflict);
  EXPECT_EQ(refused.error().what,
            "21 of 22 objects in the bucket are orphans, 95.5 percent: nothing was deleted");
  EXPECT_EQ(objects_of(data()).size(), 22u);
  search.most = 96;
  EXPECT_EQ(blobs_->orphans(search, go_on)->deleted, 21);
  for (int i = 0; i < OrphanSearch::few; ++i) add_orphan();
  search.most = 5;
  EXPECT_EQ(blobs_->orphans(search, go_on)->deleted, 20);
}

TEST_F(S3BlobsTest, SaysWhenTheBucketIsFull) {
  S3Server::get().set_quota(1);
  for (const std::string& text : {bytes(1000), bytes(3'000'000)}) {
    const auto refused = put(text);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::disk_full) << refused.error().text();
    EXPECT_NE(refused.error().what.find("has no room"), std::string::npos) << refused.error().text();
  }
  S3Server::get().set_quota(0);
  EXPECT_TRUE(put(bytes(1000)));
}

TEST_F(S3BlobsTest, SaysWhatIsWrongWithTheBucketOrTheKey) {
  const auto refusal = [&](const std::string& url, const S3Credentials& credentials) {
    S3Client client(s3_address(url).value(), credentials);
    const auto checked = client.check();
    EXPECT_FALSE(checked);
    EXPECT_EQ(checked.error().code, Code::bad_usage);
    return checked ? "" : checked.error().text();
  };
  S3Credentials wrong = S3Server::get().credentials();
  wrong.secret = "open-sesame";
  const std::string url = S3Server::get().url("any"), refused = refusal(url, wrong);
  EXPECT_TRUE(refused.starts_with("the object store refuses the access key (SignatureDoesNotMatch)"))
      << refused;
  EXPECT_EQ(refused.find("open-sesame"), std::string::npos);
  wrong = {"nobody", "open-sesame", ""};
  EXPECT_TRUE(refusal(url, wrong).starts_with("the object store refuses the access key"))
      << refusal(url, wrong);
  const std::string none = "s3://no-such-bucket" + url.substr(url.find('?'));
  EXPECT_TRUE(refusal(none, S3Server::get().credentials())
                  .starts_with("there is no such bucket in the object store (no-such-bucket)"));
}

TEST(S3Stores, ADataFolderOpensOnlyWithItsOwnBucket) {
  ASSERT_TRUE(start_secrets());
  const fs::path folder = fs::temp_directory_path() / ("vacuform-buckets-" + random_hex(8));
  const auto refusal = [&](const std::string& data, const std::string& bucket) {
    StoreOptions options;
    if (!bucket.empty()) options.blobs = S3Server::get().url(folder.filename().string() + "-" + bucket);
    options.blobs_credentials = S3Server::get().credentials_file();
    const auto store = open_store(folder / data, options);
    if (!store) return store.error().what;
    auto upload = *(*store)->upload();
    EXPECT_TRUE(upload.write("a scan"));
    EXPECT_TRUE((*store)->add_scan("a", std::move(upload), "stl"));
    return std::string("none");
  };
  EXPECT_EQ(refusal("one", "a"), "none");
  EXPECT_EQ(refusal("one", "a"), "none");
  EXPECT_EQ(refusal("one", ""), "the files of the jobs are in an object store");
  EXPECT_EQ(refusal("one", "b"), "the files of the jobs are in another bucket");
  EXPECT_EQ(refusal("two", "a"), "the bucket has the files of another data folder");
  EXPECT_EQ(refusal("three", ""), "none");
  EXPECT_EQ(refusal("three", "c"), "the files of the jobs are in the data folder");
  fs::remove_all(folder);
}

TEST(S3Address, IsReadWithItsParameters) {
  const auto full =
      s3_address("s3://scans/site-1?endpoint=https://s3.example.org:8443/&region=eu-1&addressing=virtual");
  ASSERT_TRUE(full) << full.error().text();
  EXPECT_EQ(full->prefix, "site-1/");
  EXPECT_EQ(full->url(), "https://scans.s3.example.org:8443");
  EXPECT_EQ(full->host(), "scans.s3.example.org:8443");
  EXPECT_EQ(full->root(), "");
  EXPECT_EQ(full->region, "eu-1");
  const auto least = s3_address("s3://scans?region=eu-north-1");
  ASSERT_TRUE(least);
  EXPECT_EQ(least->url(), "https://s3.eu-north-1.amazonaws.com");
  EXPECT_EQ(least->root(), "/scans");
  EXPECT_EQ(least->prefix, "");
  EXPECT_TRUE(check_blobs("") && check_blobs("file:"));
  EXPECT_TRUE(check_blobs("s3://a?endpoint=http://127.0.0.1:8085") &&
              check_blobs("s3://a?endpoint=http://[::1]:1"));
}

TEST(S3Address, IsRefusedWhereItCannotBeUsedOrIsNotSafe) {
  for (const char* text :
       {"s3://", "s3:///folder", "s3://a b", "s3://a/../b", "s3://a//b", "ftp://a", "/var/lib",
        "s3://a?endpoint=example.org", "s3://a?endpoint=http://s3.example.org",
        "s3://a?endpoint=http://127.0.0.1.example.org", "s3://a?endpoint=https://user:secret@example.org",
        "s3://a?addressing=none", "s3://a?region=", "s3://a?secret=b"}) {
    const auto checked = check_blobs(text);
    ASSERT_FALSE(checked) << text;
    EXPECT_EQ(checked.error().code, Code::bad_usage) << text;
  }
}

TEST(S3Credentials, AreReadFromAPrivateFile) {
  const fs::path file = fs::temp_directory_path() / ("vacuform-s3-key-" + random_hex(8));
  std::ofstream(file) << "[default]\naws_access_key_id = an-id\naws_secret_access_key = a-secret\n";
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  const auto found = s3_credentials(file);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->key_id, "an-id");
  EXPECT_EQ(found->secret, "a-secret");
  fs::permissions(file, fs::perms::others_read, fs::perm_options::add);
  EXPECT_EQ(s3_credentials(file).error().code, Code::bad_usage);
  std::ofstream(file) << "aws_access_key_id = an-id\n";
  fs::permissions(file, fs::perms::others_read, fs::perm_options::remove);
  EXPECT_EQ(s3_credentials(file).error().what, "the file has no access key for the object store");
  fs::remove(file);
}

// Servers with a data folder each, on one database and one bucket.
class ServersTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-servers-" + random_hex(8));
    one_ = server("one");
    two_ = server("two");
  }
  void TearDown() override {
    one_.reset();
    two_.reset();
    fs::remove_all(folder_);
  }

  std::unique_ptr<Store> server(const std::string& name) {
    StoreOptions options = with_objects(folder_ / "data", {});
    std::string schema = folder_.filename().string();
    std::replace(schema.begin(), schema.end(), '-', '_');
    options.database = PostgresServer::get().url(schema);
    options.clock = [this] { return wall_clock() + clock_set_; };
    auto store = open_store(folder_ / name, std::move(options));
    EXPECT_TRUE(store) << store.error().text();
    return store ? std::move(*store) : nullptr;
  }
  static Upload file(Store& store, const std::string& bytes) {
    auto upload = store.upload();
    EXPECT_TRUE(upload && upload->write(bytes));
    return std::move(*upload);
  }
  static Result<Job> create(Store& store, const std::string& scan) {
    NewJob job{"{}", ""};
    job.add("scan", file(store, scan), "stl");
    return store.create(std::move(job));
  }
  static std::string bytes_of(Store& store, const Blob& blob) {
    const auto reader = store.open(blob);
    if (!reader) return reader.error().text();
    std::string bytes(blob.bytes, '\0');
    EXPECT_TRUE((*reader)->read_at(0, bytes));
    return bytes;
  }
  static ObjectTable& objects(Store& store) { return dynamic_cast<ObjectTable&>(store); }

  fs::path folder_;
  std::atomic<Millis> clock_set_{0};  // by how much the clocks of the servers are wrong
  std::unique_ptr<Store> one_, two_;
};

TEST_F(ServersTest, AJobOfOneIsReadAndDeletedByTheOther) {
  const auto job = create(*one_, "a scan");
  ASSERT_TRUE(job) << job.error().text();
  EXPECT_EQ(bytes_of(*two_, job->inputs[0].blob), "a scan");
  ASSERT_TRUE(two_->cancel(job->id, {}));
  ASSERT_TRUE(two_->remove(job->id, {}));
  EXPECT_EQ(one_->job(job->id).error().code, Code::not_found);
  const auto again = create(*one_, "a scan");
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(bytes_of(*two_, again->inputs[0].blob), "a scan");
}

// One server stores the same bytes that another is deleting.
TEST_F(ServersTest, AFileThatAnAcceptedJobNamesIsNeverDeleted) {
  std::atomic<int> accepted{0}, refused{0};
  const auto work = [&](Store& store) {
    for (int i = 0; i < 25; ++i) {
      const auto job = create(store, "the same scan");
      if (!job) {
        EXPECT_EQ(job.error().code, Code::unavailable) << job.error().text();
        ++refused;
        continue;
      }
      ++accepted;
      EXPECT_EQ(bytes_of(store, job->inputs[0].blob), "the same scan");
      EXPECT_TRUE(store.cancel(job->id, {}));
      EXPECT_TRUE(store.remove(job->id, {}));
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 2; ++i)
    for (Store* store : {one_.get(), two_.get()}) threads.emplace_back([&work, store] { work(*store); });
  for (auto& thread : threads) thread.join();
  EXPECT_GT(accepted, 50) << refused;
}

TEST_F(ServersTest, AStartLeavesTheFilesOfRequestsToOtherServers) {
  for (const char* scan : {"one", "two", "three", "four"}) ASSERT_TRUE(create(*one_, scan));
  const StoredObject coming{text_hash("coming"), "0123456789abcdef", 6};
  ASSERT_TRUE(objects(*one_).add_uploading(coming));
  const StoredObject come{text_hash("come"), "0123456789abcdef", 4};
  ASSERT_TRUE(objects(*one_).add_uploading(come));
  ASSERT_TRUE(objects(*one_).object_arrived(come));
  two_.reset();
  two_ = server("two");
  EXPECT_TRUE(objects(*one_).live_object(come.sha256).value());
  ASSERT_TRUE(objects(*one_).object_arrived(coming));
  EXPECT_TRUE(objects(*one_).live_object(coming.sha256).value());
  clock_set_ = 5 * hour;  // no request takes so long
  ASSERT_TRUE(one_->expire());
  EXPECT_FALSE(objects(*two_).live_object(come.sha256).value());
  EXPECT_FALSE(objects(*two_).live_object(coming.sha256).value());
}

TEST_F(ServersTest, AnUploadContinuesOnTheOther) {
  EXPECT_TRUE(one_->shared());
  const Millis now = wall_clock();
  const StoredUpload upload{.id = random_hex(16),
                            .owner = "a",
                            .input = "scan",
                            .extension = "stl",
                            .key = random_hex(32),
                            .length = 10,
                            .created = now,
                            .expires = now + hour};
  ASSERT_TRUE(one_->add_upload(upload));
  ASSERT_TRUE(one_->add_piece(upload.id, 0, file(*one_, "one"), 4));
  ASSERT_TRUE(two_->add_piece(upload.id, 1, file(*two_, "two"), 8));
  const auto late = one_->add_piece(upload.id, 1, file(*one_, "too late"), 9);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Code::locked);
  const auto found = one_->find_upload(upload.id);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->received, 8U);
  EXPECT_EQ(found->pieces, 2);
  const auto pieces = one_->pieces(upload.id);
  ASSERT_TRUE(pieces);
  ASSERT_EQ(pieces->size(), 2U);
  EXPECT_EQ(bytes_of(*one_, (*pieces)[0]) + bytes_of(*one_, (*pieces)[1]), "onetwo");
  ASSERT_TRUE(one_->finish_upload(upload.id, file(*one_, "the whole")));
  EXPECT_EQ(two_->find_upload(upload.id)->pieces, 0);
  EXPECT_FALSE(objects(*two_).live_object(text_hash("one")).value());
  EXPECT_TRUE(two_->find_upload(upload.id)->blob);
}

}  // namespace
}  // namespace vacuform
