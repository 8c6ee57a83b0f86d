#include "api/redaction/gunzip.hpp"

#include <zlib.h>

#include <array>
#include <new>

namespace vacuform {

Result<std::string> gunzip(const ByteSource& file, std::size_t most) {
  struct Stream : z_stream {
    Stream() : z_stream{} {
      if (::inflateInit2(this, 16 + MAX_WBITS) != Z_OK) throw std::bad_alloc();
    }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    ~Stream() { ::inflateEnd(this); }
  } stream;
  const auto damaged = [](const char* why) {
    return fail(Code::corrupt_file, std::string("the packed file is damaged: ") + why, {},
                "unpack the file, or export it again");
  };
  std::array<char, 32 << 10> in{}, out{};
  std::string content;
  bool ended = false;  // behind a whole part
  for (std::uint64_t at = 0;;) {
    VACUFORM_TRY(got, file.read_at(at, in));
    if (got == 0) break;
    at += got;
    stream.next_in = reinterpret_cast<Bytef*>(in.data());
    stream.avail_in = static_cast<uInt>(got);
    while (stream.avail_in > 0 || stream.avail_out == 0) {
      if (ended) {
        // A further part, or the zeros that fill a block.
        while (stream.avail_in > 0 && *stream.next_in == 0) ++stream.next_in, --stream.avail_in;
        if (stream.avail_in == 0) break;
        if (::inflateReset(&stream) != Z_OK) return damaged("it cannot be read");
        ended = false;
      }
      stream.next_out = reinterpret_cast<Bytef*>(out.data());
      stream.avail_out = static_cast<uInt>(out.size());
      const int done = ::inflate(&stream, Z_NO_FLUSH);
      if (done == Z_BUF_ERROR) break;
      if (done != Z_OK && done != Z_STREAM_END) return damaged(stream.msg ? stream.msg : "it cannot be read");
      content.append(out.data(), out.size() - stream.avail_out);
      if (content.size() > most)
        return fail(Code::too_large,
                    "the packed file has more than " + std::to_string(most >> 20) + " MiB when unpacked", {},
                    "simplify the drawing");
      ended = done == Z_STREAM_END;
    }
  }
  if (!ended) return damaged("it ends early");
  return content;
}

}  // namespace vacuform
