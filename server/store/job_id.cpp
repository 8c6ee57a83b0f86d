#include "server/store/job_id.hpp"

#include "api/base/secrets.hpp"

namespace vacuform {

namespace {

// Writes the lowest bits of `number` into the characters [begin, end) of `id`, five a character.
void write_digits(std::string& id, std::size_t begin, std::size_t end, std::uint64_t number) {
  constexpr char digits[] = "0123456789abcdefghjkmnpqrstvwxyz";
  for (std::size_t i = end; i > begin; --i, number >>= 5) id[i - 1] = digits[number & 31];
}

}  // namespace

std::string first_job_id(Millis time) {
  std::string id(26, '0');
  write_digits(id, 0, 10, static_cast<std::uint64_t>(time));
  return id;
}

std::string make_job_id(Millis time) {
  std::string id = first_job_id(time);
  write_digits(id, 10, 18, random_number());
  write_digits(id, 18, 26, random_number());
  return id;
}

}  // namespace vacuform
