#pragma once

#include <gtest/gtest.h>

#include <string>

namespace gluevo::apps {

/// Expects a page without a script and without anything that a browser would fetch: every address
/// in an attribute or the style sheet is a data: one.
inline void ExpectSelfContained(const std::string& html) {
  // Texts are escaped, so what stands between < and > is the writer's own.
  for (const char* const banned : {"<script", "<iframe", "<object", "<embed", "@import",
                                   "srcset=", "<base", "http-equiv=\"refresh"}) {
    EXPECT_EQ(html.find(banned), std::string::npos) << banned;
  }
  // Data can be megabytes, and std::regex recurses.
  for (const std::string attribute : {" src=\"", " href=\"", " xlink:href=\"", " action=\""}) {
    for (std::size_t at = html.find(attribute); at != std::string::npos;
         at = html.find(attribute, at + 1)) {
      const std::string address = html.substr(at + attribute.size(), 40);
      EXPECT_EQ(address.rfind("data:", 0), 0U) << attribute << address;
    }
  }
  EXPECT_EQ(html.find("url("), std::string::npos);
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos) << "the browser's own check";
}

}  // namespace gluevo::apps
