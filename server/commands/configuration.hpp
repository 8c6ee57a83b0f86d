// The configuration of vacuform-server. api/base/configuration.hpp describes the sources of the settings.
#pragma once

#include <filesystem>
#include <string>

#include "api/base/configuration.hpp"
#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace vacuform {

struct Configuration {
  std::string listen = "127.0.0.1:8080";
  std::string status_listen = "127.0.0.1:0";
  std::string front;  // "https://vacuform.example.org", the TLS front; empty: no front
  std::filesystem::path data = "vacuform-data";
  std::string store;                        // "postgresql://user@host/database"; empty: SQLite in `data`
  std::string blobs;                        // "s3://bucket?endpoint=https://..."; empty: files in `data`
  std::filesystem::path blobs_credentials;  // empty: the environment
  int workers = 0;
  int lease_seconds = 30;
  double check_hours = 24;       // from one check of all that is stored to the next; 0: none
  int check_mib_per_second = 8;  // that it reads at most
  int quarantine_days = 30;
  std::filesystem::path worker_program;  // empty until add_to(): vacuform-worker beside this program
  std::string worker_user;               // user of the workers; empty: this program's user
  std::filesystem::path log;             // empty: standard error
  std::filesystem::path port_file, status_port_file;

  void add_to(ConfigurationSources& sources);
  // Where the store keeps what it has, beside `data`.
  StoreOptions store_options() const;
  // The front's name as browsers send it in Host, with its port if there is one.
  std::string front_host() const;
};

struct Address {
  std::string host;
  int port = 0;
};

// "127.0.0.1:8080". Errors: bad_usage if it is no address, or is not on loopback and there is no front.
Result<Address> listen_address(const std::string& text, const std::string& option, const std::string& front);

// All checks that are possible without starting: addresses, the front, the worker program.
Result<void> check(const Configuration& configuration);

}  // namespace vacuform
