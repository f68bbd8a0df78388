#include "markup.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gluevo::apps {
namespace {

TEST(EscapeTest, NothingFromOutsideBecomesMarkup) {
  EXPECT_EQ(Escape("a <script>\"x\" & 'y'</script>"),
            "a &lt;script&gt;&quot;x&quot; &amp; &#39;y&#39;&lt;/script&gt;");
  EXPECT_EQ(Escape("Gr\u00FC\u00DFe \u4E16 \U0001F600\tb\n"),
            "Gr\u00FC\u00DFe \u4E16 \U0001F600\tb\n");
}

TEST(EscapeTest, ReplacesWhatIsNoText) {
  const std::string bad = "\uFFFD";
  EXPECT_EQ(Escape(std::string_view("\0\x1b\x7f", 3)), bad + bad + bad);
  EXPECT_EQ(Escape("\xFF"), bad);
  EXPECT_EQ(Escape("a\xC3"), "a" + bad) << "cut short";
  EXPECT_EQ(Escape("\xC0\xBC"), bad + bad) << "'<' written too long";
  EXPECT_EQ(Escape("\xED\xA0\x80"), bad + bad + bad) << "a surrogate";
  EXPECT_EQ(Escape("\xF4\x90\x80\x80"), bad + bad + bad + bad) << "beyond Unicode";
  EXPECT_EQ(Escape("\xE2\x28\xA1"), bad + "(" + bad);
}

TEST(FixedTest, WritesNumbersForPeople) {
  EXPECT_EQ(Fixed(1.25, 1), "1.2");
  EXPECT_EQ(Fixed(-3.0, 2), "\u22123.00");
  EXPECT_EQ(Fixed(-0.001, 2), "0.00");
  EXPECT_EQ(Fixed(NAN, 2), "\u2013");
  EXPECT_EQ(Fixed(-INFINITY, 0), "\u2013");
  EXPECT_EQ(Fixed(1e300, 0).size(), 301U);
}

TEST(CoordinateTest, IsShort) {
  EXPECT_EQ(Coordinate(12.0), "12");
  EXPECT_EQ(Coordinate(-0.04), "0");
  EXPECT_EQ(Coordinate(-7.26), "-7.3");
}

// RFC 4648, section 10.
TEST(Base64Test, GivesTheStandardsExamples) {
  const auto encode = [](const std::string& text) {
    return Base64(std::vector<uint8_t>(text.begin(), text.end()));
  };
  EXPECT_EQ(encode(""), "");
  EXPECT_EQ(encode("f"), "Zg==");
  EXPECT_EQ(encode("fo"), "Zm8=");
  EXPECT_EQ(encode("foo"), "Zm9v");
  EXPECT_EQ(encode("foobar"), "Zm9vYmFy");
  EXPECT_EQ(encode("\xFB\xFF\xFE"), "+//+");
}

}  // namespace
}  // namespace gluevo::apps
