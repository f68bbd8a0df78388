// gluevo live --view as people see it: in a browser.

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "apps/child.h"
#include "apps/command_test.h"
#include "apps/view/browser.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::json;

class ViewTest : public CommandTest {
 protected:
  void SetUp() override {
    if (!Browser::IsThere()) {
      GTEST_SKIP() << "chromium is not there (apt-get install chromium)";
    }
    ASSERT_EQ(
        Run("simulate -o " + Path("flight") + " --duration 3 --rate 10 --width 320 --height 240")
            .exit_code,
        0);
  }
  std::unique_ptr<Child> Start(const std::string& view, const std::string& more = "--quiet") const {
    return std::make_unique<Child>(
        std::vector<std::string>{"live", Path("flight"), "--method", "klt", "--rounds", "100000",
                                 "-o", Path("out"), "--view", view, more},
        Path("log"));
  }
  std::string Url() const {
    for (int i = 0; i < 4000; ++i) {
      std::istringstream lines(Contents(Path("log")));
      for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("view: ") && !lines.eof()) {
          return line.substr(6);
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return "";
  }
};

TEST_F(ViewTest, ShowsThePathAndComesBackAfterARestart) {
  std::unique_ptr<Child> live = Start("0");
  const std::string url = Url();
  ASSERT_EQ(url.rfind("http://127.0.0.1:", 0), 0U) << Contents(Path("log"));
  Browser browser;
  browser.Open(url);
  EXPECT_TRUE(browser.Becomes("window.gluevo && gluevo.images > 1 && gluevo.landmarks > 10"));
  const int poses = browser.Evaluate("gluevo.poses");
  const int images = browser.Evaluate("gluevo.images");
  EXPECT_TRUE(browser.Becomes("gluevo.poses > " + std::to_string(poses + 5)));
  EXPECT_TRUE(browser.Becomes("gluevo.images > " + std::to_string(images + 1)));
  EXPECT_TRUE(browser.Becomes("document.getElementById('state').textContent == 'tracking'"));
  EXPECT_TRUE(browser.Becomes("document.querySelectorAll('#times b').length >= 3"));
  // Something is drawn in the image and, by WebGL, above and in space.
  EXPECT_TRUE(browser.Becomes("document.getElementById('picture').width >= 640"));
  EXPECT_TRUE(
      browser.Becomes("above.gl !== null && space.gl !== null && above.gl.getError() == 0"));

  EXPECT_EQ(browser.Evaluate("document.getElementById('save').disabled"), true);
  browser.Evaluate("document.getElementById('pause').click()");
  EXPECT_TRUE(browser.Becomes("gluevo.status.state == 'paused'"));
  const int paused_at = browser.Evaluate("gluevo.status.frames");
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_LE(browser.Evaluate("gluevo.status.frames").get<int>(), paused_at + 2);
  browser.Evaluate("document.getElementById('pause').click()");
  EXPECT_TRUE(browser.Becomes("gluevo.status.frames > " + std::to_string(paused_at + 2)));

  live->Send(SIGINT);
  EXPECT_EQ(live->ExitCode(), 0) << Contents(Path("log"));
  EXPECT_GT(Json::parse(Contents(Path("out/metrics.json")))["live"]["frames_paused"], 2);
  EXPECT_TRUE(browser.Becomes("!gluevo.connected"));
  const std::string port = url.substr(17, url.size() - 18);
  live = Start(port);
  EXPECT_TRUE(browser.Becomes("gluevo.connected && gluevo.connections == 2")) << port;
  EXPECT_TRUE(browser.Becomes("gluevo.poses > 2"));

  for (const std::string& request : browser.requests()) {
    EXPECT_TRUE(request.starts_with("http://127.0.0.1:" + port + "/") ||
                request.starts_with("ws://127.0.0.1:" + port + "/") ||
                request.starts_with("data:") || request.starts_with("blob:"))
        << request;
  }
  EXPECT_GE(browser.requests().size(), 2U);
  live->Send(SIGINT);
  EXPECT_EQ(live->ExitCode(), 0);
}

TEST_F(ViewTest, SavesTheMap) {
  const std::unique_ptr<Child> live = Start("0", "--loops=on");
  const std::string url = Url();
  Browser browser;
  browser.Open(url);
  EXPECT_TRUE(
      browser.Becomes("window.gluevo && gluevo.poses > 10 && "
                      "!document.getElementById('save').disabled"));
  browser.Evaluate("document.getElementById('save').click()");
  EXPECT_TRUE(browser.Becomes("gluevo.status.message.startsWith('saved ')"));
  EXPECT_EQ(Run("map info " + Path("out/places.map")).exit_code, 0);
  live->Send(SIGINT);
  EXPECT_EQ(live->ExitCode(), 0) << Contents(Path("log"));
}

}  // namespace
}  // namespace gluevo::apps
