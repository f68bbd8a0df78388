#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "containers.h"
#include "gluevo/nn/error.h"
#include "message_of.h"

// What every reader of files from anywhere has to show.

namespace gluevo::weights_tools {

inline std::string TestFile(const std::string& name) {
  std::ifstream stream(std::string(GLUEVO_TEST_DATA_DIR) + "/weights/" + name, std::ios::binary);
  EXPECT_TRUE(stream) << name;
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline Container Parse(const std::string& bytes) {
  // A copy of exactly this size lets the address sanitiser see every byte read beyond it.
  const std::vector<char> copy(bytes.begin(), bytes.end());
  return ParseContainer(copy.data(), copy.size(), "file");
}

/// The message of the Error that this throws; fails where it throws none, or one of several lines.
inline std::string MessageOf(const std::function<void()>& run) {
  std::string message = gluevo::MessageOf(run);
  EXPECT_NE(message, "no error");
  return message;
}

/// Expects an Error of one line that begins so and says this.
inline void ExpectRefused(const std::string& bytes, const std::string& start,
                          const std::string& phrase) {
  const std::string message = MessageOf([&] { Parse(bytes); });
  EXPECT_EQ(message.rfind(start, 0), 0U) << message << "\nexpected: " << start;
  EXPECT_NE(message.find(phrase), std::string::npos) << message << "\nexpected: " << phrase;
}

/// Every beginning of a file but the whole is refused, by Error and nothing else.
inline void ExpectEveryTruncationRefused(const std::string& bytes) {
  ASSERT_NO_THROW(Parse(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(Parse(bytes.substr(0, size)), Error) << "cut to " << size << " bytes";
  }
}

/// Calls `read` with one to four bytes of the file changed, so many times: it may throw Error, of
/// one line, and nothing else. Returns how often it did.
inline int SurviveFlips(const std::string& bytes, int rounds,
                        const std::function<void(const std::string&)>& read) {
  std::mt19937 random(20260517);
  int refused = 0;
  for (int round = 0; round < rounds; ++round) {
    std::string changed = bytes;
    const int flips = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < flips; ++i) {
      changed[random() % changed.size()] = static_cast<char>(random());
    }
    try {
      read(changed);
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  return refused;
}

inline void ExpectFlipsSurvived(const std::string& bytes, int rounds = 10000) {
  // Most bytes of these files are structure.
  EXPECT_GT(SurviveFlips(bytes, rounds, Parse), rounds / 4);
}

}  // namespace gluevo::weights_tools
