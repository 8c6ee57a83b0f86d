#include "worker/printing/output_profile.hpp"

#include <lcms2.h>

#include <algorithm>
#include <new>

namespace vacuform {

namespace {

constexpr std::size_t header_bytes = 128;
constexpr std::size_t date_at = 24, date_bytes = 12;  // of its creation, in the header

struct CloseProfile {
  void operator()(void* profile) const { cmsCloseProfile(profile); }
};
using ProfileHandle = std::unique_ptr<void, CloseProfile>;

// Messages of the library are dropped: what failed is known from what it returns.
void drop_message(cmsContext, cmsUInt32Number, const char*) {}

std::string space_name(cmsColorSpaceSignature space) {
  if (space == cmsSigCmykData) return "CMYK";
  if (space == cmsSigGrayData) return "gray";
  if (space == cmsSigLabData) return "L*a*b*";
  return "another colour space than RGB";
}

}  // namespace

struct OutputProfile::State {
  std::vector<std::uint8_t> bytes;
  cmsContext context = nullptr;
  cmsHTRANSFORM transform = nullptr, back = nullptr;

  State() : context(cmsCreateContext(nullptr, nullptr)) {
    if (!context) throw std::bad_alloc();
    cmsSetLogErrorHandlerTHR(context, drop_message);
  }
  State(const State&) = delete;
  ~State() {
    for (const cmsHTRANSFORM each : {transform, back})
      if (each) cmsDeleteTransform(each);
    cmsDeleteContext(context);
  }
};

Result<OutputProfile> OutputProfile::read(std::span<const std::uint8_t> bytes, const std::string& file_name) {
  const char* other = "give the RGB profile of the printer and its driver as an ICC file (.icc, .icm)";
  if (bytes.size() > largest_bytes)
    return fail(Code::too_large, "the colour profile has more than 4 MiB", file_name, other);
  const std::uint8_t signature[] = {'a', 'c', 's', 'p'};
  if (bytes.size() < header_bytes || !std::equal(signature, signature + 4, bytes.begin() + 36))
    return fail(Code::unsupported_format, "the file is not an ICC profile", file_name, other);
  const auto corrupt = [&] {
    return fail(Code::corrupt_file, "the ICC profile is damaged, or colours cannot be converted to it",
                file_name, other);
  };
  auto state = std::make_shared<State>();
  state->bytes.assign(bytes.begin(), bytes.end());
  const ProfileHandle profile(cmsOpenProfileFromMemTHR(state->context, state->bytes.data(),
                                                       static_cast<cmsUInt32Number>(state->bytes.size())));
  if (!profile) return corrupt();
  const cmsColorSpaceSignature space = cmsGetColorSpace(profile.get());
  if (space != cmsSigRgbData)
    return fail(
        Code::unsupported_format,
        std::string("the colour profile is for ") + space_name(space) + ", but print.png holds RGB",
        file_name,
        "give the RGB profile of the printer driver, or leave the profile out: the print then carries sRGB, "
        "which the printer's software converts");
  const cmsProfileClassSignature kind = cmsGetDeviceClass(profile.get());
  if (kind != cmsSigOutputClass && kind != cmsSigDisplayClass && kind != cmsSigColorSpaceClass)
    return fail(Code::unsupported_format, "the colour profile is not one of an output device", file_name,
                other);
  const ProfileHandle srgb(cmsCreate_sRGBProfileTHR(state->context));
  if (!srgb) throw std::bad_alloc();
  const auto transform = [&](const ProfileHandle& from, const ProfileHandle& to) {
    return cmsCreateTransformTHR(state->context, from.get(), TYPE_RGBA_8, to.get(), TYPE_RGBA_8,
                                 INTENT_RELATIVE_COLORIMETRIC,
                                 cmsFLAGS_BLACKPOINTCOMPENSATION | cmsFLAGS_COPY_ALPHA | cmsFLAGS_NOCACHE);
  };
  state->transform = transform(srgb, profile);
  state->back = transform(profile, srgb);
  if (!state->transform || !state->back) return corrupt();
  OutputProfile out;
  out.state_ = std::move(state);
  return out;
}

std::span<const std::uint8_t> OutputProfile::icc() const {
  return state_ ? std::span<const std::uint8_t>(state_->bytes) : std::span<const std::uint8_t>();
}

void OutputProfile::convert(std::span<std::uint8_t> rgba) const {
  if (state_)
    cmsDoTransform(state_->transform, rgba.data(), rgba.data(),
                   static_cast<cmsUInt32Number>(rgba.size() / 4));
}

void OutputProfile::convert_back(std::span<std::uint8_t> rgba) const {
  if (state_)
    cmsDoTransform(state_->back, rgba.data(), rgba.data(), static_cast<cmsUInt32Number>(rgba.size() / 4));
}

std::vector<std::uint8_t> srgb_icc() {
  const ProfileHandle profile(cmsCreate_sRGBProfile());
  cmsUInt32Number size = 0;
  if (!profile || !cmsSaveProfileToMem(profile.get(), nullptr, &size)) throw std::bad_alloc();
  std::vector<std::uint8_t> out(size);
  if (!cmsSaveProfileToMem(profile.get(), out.data(), &size) || size < header_bytes) throw std::bad_alloc();
  // The library writes the time of day; 1 January 2000 instead.
  const std::uint8_t date[date_bytes] = {0x07, 0xd0, 0, 1, 0, 1};
  std::copy_n(date, date_bytes, out.begin() + date_at);
  return out;
}

}  // namespace vacuform
