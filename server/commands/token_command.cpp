#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/access/token_json.hpp"
#include "server/commands/ask_server.hpp"
#include "server/commands/store_command.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

constexpr const char* tokens_path = "/api/v1/tokens";

class TokenCommand final : public StoreCommand {
 public:
  void add_to(CLI::App& app) override;

 private:
  Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) override;
  Result<void> create() const;
  Result<void> list() const;
  Result<void> link() const;
  Result<void> revoke() const;
  Result<void> check_id() const;

  CLI::App *create_ = nullptr, *list_ = nullptr, *link_ = nullptr, *revoke_ = nullptr;
  std::filesystem::path data_, out_;
  StoreOptions places_;
  std::string owner_, scopes_, id_;
  double days_ = 0;
};

void TokenCommand::add_to(CLI::App& app) {
  CLI::App& token = add(app, "token", "Make, list and revoke tokens, and make links that sign in");
  token.require_subcommand(1);
  create_ = token.add_subcommand("create", "Make a token; it is shown once");
  list_ = token.add_subcommand("list", "List the tokens, without their secrets");
  link_ = token.add_subcommand("link",
                               "Make a link that signs a browser in once, within an hour, without the token");
  revoke_ = token.add_subcommand("revoke", "Revoke a token, at once and for good");
  for (CLI::App* command : {create_, list_, link_, revoke_}) add_data(*command);
  create_
      ->add_option("--owner", owner_, "Whose jobs it makes and sees: a place or a purpose, such as station-3")
      ->required();
  create_->add_option("--scopes", scopes_, "Some of submit, read, work, admin, with commas")
      ->required()
      ->type_name("LIST");
  create_->add_option("--days", days_, "Days after which it expires (default: never)")
      ->check(CLI::Range(0.0001, 3650.0));
  create_->add_option("--out", out_, "File that receives it, instead of standard output")->type_name("FILE");
  for (CLI::App* command : {link_, revoke_})
    command->add_option("id", id_, "The id, as list shows it")->required();
}

Result<void> TokenCommand::run_on(const std::filesystem::path& data, const StoreOptions& places) {
  data_ = data;
  places_ = places;
  if (create_->parsed()) return create();
  if (list_->parsed()) return list();
  if (link_->parsed()) return link();
  return revoke();
}

Result<void> TokenCommand::create() const {
  const auto scopes = Scopes::from(scopes_);
  if (!scopes)
    return fail(Code::bad_usage, "not a list of scopes: " + scopes_, "--scopes",
                "give for example submit,read");
  ordered_json wanted = {{"owner", owner_}, {"scopes", ordered_json::array()}};
  for (std::size_t i = 0; i < scope_names.size(); ++i)
    if (scopes->has(static_cast<Scope>(i))) wanted["scopes"].push_back(scope_names[i]);
  if (days_ > 0) wanted["days"] = days_;
  const auto here = [&](Store& store) -> Result<ordered_json> {
    VACUFORM_TRY(asked_for, new_token_from(wanted, wall_clock()));
    VACUFORM_TRY(made, make_token(store, asked_for));
    ordered_json answer = token_json(made.token);
    answer["token"] = made.text;
    return answer;
  };
  // The first token is made before the first start: in the configured folder, or in an empty one.
  std::error_code error;
  const bool may_begin = !data_named() || std::filesystem::is_empty(data_, error);
  if (!(may_begin && !error) && !has_store(data_)) return no_store(data_);
  VACUFORM_TRY(made, do_or_ask(data_, places_, here, "POST", tokens_path, wanted.dump()));
  const std::string text = made.value("token", "") + "\n";
  if (!out_.empty()) return write_text_file(out_, text);
  std::fputs(text.c_str(), stdout);
  return {};
}

Result<void> TokenCommand::list() const {
  const auto here = [](Store& store) -> Result<ordered_json> {
    VACUFORM_TRY(tokens, store.tokens());
    ordered_json all = ordered_json::array();
    for (const Token& token : tokens) all.push_back(token_json(token));
    return ordered_json{{"tokens", all}};
  };
  if (!has_store(data_)) return no_store(data_);
  VACUFORM_TRY(answer, do_or_ask(data_, places_, here, "GET", tokens_path));
  for (const auto& token : answer.value("tokens", ordered_json::array())) {
    std::string scopes;
    for (const auto& scope : token.at("scopes")) {
      if (!scopes.empty()) scopes += ',';
      scopes += scope.get<std::string>();
    }
    const auto text = [&](const char* key) {
      return token.at(key).is_string() ? token.at(key).get<std::string>() : std::string("-");
    };
    std::printf("%s  owner %s  scopes %s  created %s  expires %s  revoked %s\n", text("id").c_str(),
                text("owner").c_str(), scopes.c_str(), text("created").c_str(), text("expires").c_str(),
                text("revoked").c_str());
  }
  return {};
}

Result<void> TokenCommand::check_id() const {
  if (id_.find_first_not_of("0123456789abcdef") != std::string::npos)
    return fail(Code::bad_usage, "not the id of a token: " + id_, "id",
                "take it from vacuform-server token list");
  return has_store(data_) ? Result<void>() : no_store(data_);
}

// Only a server that runs has an address to open.
Result<void> TokenCommand::link() const {
  VACUFORM_CHECK(check_id());
  const Error stopped{Code::unavailable, "no server runs on this data folder", data_.string(), "start it"};
  VACUFORM_TRY(answer, ask_server(data_, stopped, "POST", tokens_path + ("/" + id_ + "/link")));
  VACUFORM_TRY(url, server_url(data_, stopped));
  std::printf("%s%s\n", url.c_str(), answer.value("path", "").c_str());
  return {};
}

Result<void> TokenCommand::revoke() const {
  VACUFORM_CHECK(check_id());
  const auto here = [&](Store& store) -> Result<ordered_json> {
    VACUFORM_CHECK(store.revoke_token(id_));
    return ordered_json::object();
  };
  VACUFORM_CHECK(do_or_ask(data_, places_, here, "DELETE", tokens_path + ("/" + id_)));
  return {};
}

}  // namespace

StoreCommandPointer token_command() { return std::make_unique<TokenCommand>(); }

}  // namespace vacuform
