#include "text_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "gluevo/nn/error.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

TEST(TextFileTest, CommentsBeginInThreeWays) {
  EXPECT_TRUE(IsComment("# a"));
  EXPECT_TRUE(IsComment("% a"));
  EXPECT_TRUE(IsComment("// a"));
  EXPECT_FALSE(IsComment("/data/a.png"));
  EXPECT_FALSE(IsComment(""));
}

TEST(TextFileTest, SeparatorsAreToldFromDecimalCommas) {
  const auto separator = [](const std::string& text) { return SeparatorOf("file", {1, text}); };
  EXPECT_EQ(separator("1 2\t3"), ' ');
  EXPECT_EQ(separator("1,2,3"), ',');
  EXPECT_EQ(separator("1, 2, 3"), ',');
  EXPECT_EQ(separator("1;2;3"), ';');
  EXPECT_EQ(separator("1403,left image.png"), ',');
  EXPECT_THROW(separator("1,5;2,5"), Error);
  EXPECT_THROW(separator("1,5 2,5"), Error);
}

TEST(TextFileTest, TablesBeginWithTheirFirstNumber) {
  const TemporaryFolder folder;
  const auto rows = [&](const std::string& text) {
    const std::filesystem::path path = folder.path() / "data.csv";
    std::ofstream(path, std::ios::binary) << text;
    return ReadTable(path);
  };
  const auto table = rows("timestamp [ns],filename\r\n\r\n100,100.png\r\nend,of it\r\n");
  ASSERT_EQ(table.size(), 2U);
  EXPECT_EQ(table[0].number, 3);
  EXPECT_EQ(table[0].text, "100,100.png");
  EXPECT_EQ(rows("\xEF\xBB\xBF#timestamp [ns],filename\n100,100.png\n").size(), 1U);
  EXPECT_EQ(rows("no number,at all\n").size(), 1U);
  EXPECT_TRUE(rows("").empty());
}

// It opens, and reading it fails, as a file on a bad sector does.
TEST(TextFileTest, AFileWhoseBytesCannotBeReadIsNamed) {
  try {
    ReadText("/proc/self/mem");
    FAIL() << "no Error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "/proc/self/mem: cannot be read: Input/output error");
  }
}

TEST(TextFileTest, OtherEncodingsAreNamed) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      SplitLines(text, "file", /*skip_comments=*/true);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  using std::string_literals::operator""s;
  EXPECT_NE(message("\xFF\xFE\x31\x00"s).find("UTF-16"), std::string::npos);
  EXPECT_NE(message("1\0,\0"s).find("UTF-16"), std::string::npos);
  EXPECT_NE(message("1,2\n3,\0"s).find("zero bytes"), std::string::npos);
  EXPECT_EQ(message("caf\xE9 1"), "");
}

}  // namespace
}  // namespace gluevo::vo
