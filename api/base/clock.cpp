#include "api/base/clock.hpp"

#include <time.h>

#include <chrono>
#include <cstdio>
#include <regex>

namespace vacuform {

Millis wall_clock() {
  using namespace std::chrono;
  return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

Millis boot_clock() {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return now.tv_sec * Millis{1000} + now.tv_nsec / 1'000'000;
}

std::string rfc3339(Millis time) {
  using namespace std::chrono;
  const sys_time<milliseconds> instant{milliseconds(time)};
  const auto day = floor<days>(instant);
  const year_month_day date(day);
  const hh_mm_ss clock(instant - day);
  char text[64];
  std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()), static_cast<int>(clock.subseconds().count()));
  return text;
}

std::optional<Millis> from_rfc3339(const std::string& text) {
  using namespace std::chrono;
  static const std::regex form(
      R"((\d{4})-(\d{2})-(\d{2})[Tt](\d{2}):(\d{2}):(\d{2})(?:\.(\d{1,9}))?(?:[Zz]|([+-])(\d{2}):(\d{2})))");
  std::smatch part;
  if (text.size() > 40 || !std::regex_match(text, part, form)) return std::nullopt;
  const auto number = [&](std::size_t i) { return part[i].matched ? std::stoi(part[i].str()) : 0; };
  const year_month_day date(year(number(1)), month(static_cast<unsigned>(number(2))),
                            day(static_cast<unsigned>(number(3))));
  if (!date.ok() || number(4) > 23 || number(5) > 59 || number(6) > 60 || number(9) > 23 || number(10) > 59)
    return std::nullopt;
  const int millis = std::stoi((part[7].str() + "000").substr(0, 3));
  const int offset = (part[8].str() == "-" ? -1 : 1) * (number(9) * 60 + number(10));
  return duration_cast<milliseconds>(sys_days(date).time_since_epoch()).count() +
         ((number(4) * 60LL + number(5) - offset) * 60 + number(6)) * 1000 + millis;
}

}  // namespace vacuform
