// Health and metrics: what they say, and that it can be read by the machines that it is meant for.
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "server_fixture.hpp"

namespace vacuform {
namespace {

class ServerStatus : public ServerTest {};

bool has_line(const std::string& text, const std::string& line) {
  return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

TEST_F(ServerStatus, SaysThatItLivesAndCanWork) {
  EXPECT_EQ(status("/healthz").body, "{\"status\":\"ok\"}\n");
  EXPECT_EQ(status("/readyz").body, "{\"status\":\"ready\",\"durability\":\"local\"}\n");
  EXPECT_EQ(status("/api/v1/jobs").status, 404);                        // jobs are not there
  Status nowhere{*store_, metrics_, "/nowhere", [] { return 0; }, 64};  // as little room as a full disk has
  http::ServerOptions options;
  options.refuse = refuse;
  const auto server = http::Server::start(std::move(options), status_routes(nowhere));
  ASSERT_TRUE(server);
  const int socket = connected_to(**server);
  send_all(socket, "GET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const Answer full = parsed(receive_all(socket));
  EXPECT_EQ(full.status, 503);
  EXPECT_FALSE(full.header("Retry-After").empty());
  EXPECT_EQ(status("/healthz").status, 200);
}

TEST_F(ServerStatus, CountsRequestsJobsAndLostLeases) {
  ASSERT_EQ(submit().status, 202);
  ASSERT_EQ(submit().status, 202);
  ask("GET", "/api/v1/jobs/none");
  ask("BREW", "/api/v1/jobs");
  metrics_.leases_lost(3);
  const std::string text = status("/metrics").body;
  EXPECT_TRUE(has_line(text, "vacuform_jobs{state=\"queued\"} 2")) << text;
  EXPECT_TRUE(has_line(text, "vacuform_jobs{state=\"running\"} 0"));
  EXPECT_TRUE(has_line(
      text, "vacuform_http_requests_total{route=\"/api/v1/jobs\",method=\"POST\",status=\"202\"} 2"));
  EXPECT_TRUE(has_line(
      text, "vacuform_http_requests_total{route=\"/api/v1/jobs/{id}\",method=\"GET\",status=\"404\"} 1"));
  EXPECT_EQ(text.find("BREW"), std::string::npos);
  EXPECT_TRUE(has_line(text, "vacuform_http_request_seconds_count{route=\"/api/v1/jobs\"} 2")) << text;
  EXPECT_TRUE(has_line(text, "vacuform_http_request_seconds_count{route=\"/api/v1/jobs/{id}\"} 1"));
  EXPECT_TRUE(has_line(text, "vacuform_http_request_seconds_count{route=\"none\"} 1"));
  EXPECT_TRUE(has_line(text, "vacuform_leases_lost_total 3"));
  EXPECT_TRUE(has_line(text, "vacuform_http_connections_limit 64"));
}

TEST_F(ServerStatus, CountsHowJobsEndAndHowLongTheyTook) {
  Job job;
  job.state = JobState::succeeded;
  job.started = 1'000;
  job.ended = 8'500;
  metrics_.job_ended(job);
  job.state = JobState::cancelled;
  job.kind = JobKind::inspection;
  job.started.reset();
  metrics_.job_ended(job);
  const std::string text = status("/metrics").body;
  const std::string labels = "{kind=\"print\",outcome=\"succeeded\"";
  EXPECT_TRUE(has_line(text, "vacuform_jobs_ended_total" + labels + "} 1")) << text;
  EXPECT_TRUE(has_line(text, "vacuform_jobs_ended_total{kind=\"inspection\",outcome=\"cancelled\"} 1"));
  EXPECT_TRUE(has_line(text, "vacuform_job_duration_seconds_bucket" + labels + ",le=\"5\"} 0"));
  EXPECT_TRUE(has_line(text, "vacuform_job_duration_seconds_bucket" + labels + ",le=\"15\"} 1"));
  EXPECT_TRUE(has_line(text, "vacuform_job_duration_seconds_sum" + labels + "} 7.5"));
  EXPECT_TRUE(has_line(text, "vacuform_job_duration_seconds_count" + labels + "} 1"));
}

// The text format: every sample has a family announced before it, the buckets never fall, and the last is the count.
TEST_F(ServerStatus, WritesWhatPrometheusReads) {
  submit();
  const Answer answer = status("/metrics");
  EXPECT_EQ(answer.header("Content-Type"), "text/plain; version=0.0.4; charset=utf-8");
  const std::regex head(R"(# (HELP \S+ .+|TYPE \S+ (gauge|counter|histogram)))");
  const std::regex sample(R"(([a-z_]+)(\{[a-z_]+="[^"\\\n]*"(,[a-z_]+="[^"\\\n]*")*\})? [0-9.e+-]+)");
  std::istringstream text(answer.body);
  std::string family;
  double last_bucket = 0;
  int samples = 0;
  for (std::string line; std::getline(text, line); ++samples) {
    std::smatch match;
    if (line.starts_with("#")) {
      ASSERT_TRUE(std::regex_match(line, head)) << line;
      family = line.substr(7, line.find(' ', 7) - 7);
      continue;
    }
    ASSERT_TRUE(std::regex_match(line, match, sample)) << line;
    EXPECT_TRUE(match[1].str().starts_with(family)) << line;
    const double value = std::stod(line.substr(line.rfind(' ')));
    if (line.find("_bucket") != std::string::npos) {
      EXPECT_GE(value, last_bucket) << line;
      last_bucket = value;
    }
  }
  EXPECT_GT(samples, 20);
  EXPECT_EQ(last_bucket, 1);
}

}  // namespace
}  // namespace vacuform
