#pragma once

#include <array>
#include <ostream>
#include <streambuf>

namespace gluevo::nn {

/// What is put out goes to an open file. Unlike std::ofstream it knows why it failed.
class DescriptorBuffer : public std::streambuf {
 public:
  explicit DescriptorBuffer(int descriptor);
  /// errno of the first failure; 0 where there was none.
  int error() const { return error_; }

 protected:
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int sync() override;

 private:
  bool Drain();
  bool Write(const char* text, std::streamsize size);

  int descriptor_;
  int error_ = 0;
  std::array<char, 1 << 16> buffer_;
};

/// It does not close the file.
class DescriptorStream : public std::ostream {
 public:
  explicit DescriptorStream(int descriptor) : std::ostream(nullptr), buffer_(descriptor) {
    rdbuf(&buffer_);
  }
  /// As DescriptorBuffer's.
  int error() const { return buffer_.error(); }

 private:
  DescriptorBuffer buffer_;
};

}  // namespace gluevo::nn
