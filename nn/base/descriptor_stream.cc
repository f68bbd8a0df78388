#include "descriptor_stream.h"

#include <unistd.h>

#include <cerrno>

namespace gluevo::nn {

DescriptorBuffer::DescriptorBuffer(int descriptor) : descriptor_(descriptor) {
  setp(buffer_.data(), buffer_.data() + buffer_.size());
}

DescriptorBuffer::int_type DescriptorBuffer::overflow(int_type character) {
  if (!Drain()) {
    return traits_type::eof();
  }
  if (traits_type::eq_int_type(character, traits_type::eof())) {
    return traits_type::not_eof(character);
  }
  return sputc(traits_type::to_char_type(character));
}

std::streamsize DescriptorBuffer::xsputn(const char* text, std::streamsize size) {
  if (size <= epptr() - pptr()) {
    return std::streambuf::xsputn(text, size);
  }
  return Drain() && Write(text, size) ? size : 0;
}

int DescriptorBuffer::sync() { return Drain() ? 0 : -1; }

bool DescriptorBuffer::Drain() {
  const bool is_written = Write(pbase(), pptr() - pbase());
  setp(buffer_.data(), buffer_.data() + buffer_.size());
  return is_written;
}

bool DescriptorBuffer::Write(const char* text, std::streamsize size) {
  while (size > 0 && error_ == 0) {
    const ssize_t written = ::write(descriptor_, text, static_cast<std::size_t>(size));
    if (written >= 0) {
      text += written;
      size -= written;
    } else if (errno != EINTR) {
      error_ = errno;
    }
  }
  return error_ == 0;
}

}  // namespace gluevo::nn
