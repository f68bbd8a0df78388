#include "view_server.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "message_of.h"
#include "view_page.h"
#include "web_client.h"

namespace gluevo::apps {
namespace {

using namespace std::chrono_literals;

std::string PortOf(const ViewServer& server) {
  const std::string url = server.url();
  const std::size_t colon = url.rfind(':');
  return url.substr(colon + 1, url.find('/', colon) - colon - 1);
}

void WaitFor(const std::function<bool()>& condition) {
  for (int i = 0; i < 2000 && !condition(); ++i) {
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_TRUE(condition());
}

TEST(ViewAddressTest, IsReadInItsForms) {
  EXPECT_EQ(ParseViewAddress("9000").port, 9000);
  EXPECT_TRUE(ParseViewAddress("9000").is_loopback());
  EXPECT_EQ(ParseViewAddress("0.0.0.0:90").host, "0.0.0.0");
  EXPECT_FALSE(ParseViewAddress("0.0.0.0:90").is_loopback());
  EXPECT_EQ(ParseViewAddress("[::1]:90").host, "::1");
  EXPECT_EQ(ParseViewAddress("[::1]:90").port, 90);
  EXPECT_EQ(ParseViewAddress("localhost").port, 8080);
  for (const std::string wrong : {"", "host:", "host:x", "0.0.0.0:P", ":80", "70000:1x"}) {
    EXPECT_EQ(MessageOf([&] { ParseViewAddress(wrong); }),
              "--view is \"" + wrong +
                  "\"; expected PORT, ADDRESS or ADDRESS:PORT, as in 8080 or 0.0.0.0:8080");
  }
  for (const std::string wrong : {"99999", "host:70000"}) {
    EXPECT_EQ(MessageOf([&] { ParseViewAddress(wrong); }),
              "--view is \"" + wrong + "\"; expected a port up to 65535");
  }
  EXPECT_EQ(ParseViewAddress("[::1]:90").NameForOthers(), "[::1]");
  for (const std::string all : {"0.0.0.0:90", "[::]:90"}) {
    EXPECT_EQ(ParseViewAddress(all).NameForOthers().find_first_of("[:"), std::string::npos) << all;
  }
  EXPECT_EQ(MakeViewToken().size(), 16U);
  EXPECT_NE(MakeViewToken(), MakeViewToken());
}

TEST(ViewAddressTest, OtherPagesMayNotAsk) {
  const ViewAddress loopback;
  EXPECT_TRUE(IsOwnRequest(loopback, "127.0.0.1:8080", "", "/"));
  EXPECT_TRUE(IsOwnRequest(loopback, "localhost:8080", "http://localhost:8080", "/stream"));
  EXPECT_FALSE(IsOwnRequest(loopback, "localhost:8080", "http://elsewhere.org", "/stream"));
  EXPECT_FALSE(IsOwnRequest(loopback, "elsewhere.org:8080", "", "/"));
  const ViewAddress open{.host = "0.0.0.0", .token = "secret"};
  EXPECT_TRUE(IsOwnRequest(open, "robot:8080", "http://robot:8080", "/stream?token=secret"));
  EXPECT_FALSE(IsOwnRequest(open, "robot:8080", "", "/stream?token=secre"));
  EXPECT_FALSE(IsOwnRequest(open, "robot:8080", "", "/stream"));
  EXPECT_FALSE(IsOwnRequest(open, "127.0.0.1:8080", "", "/"));
}

TEST(ViewServerTest, GivesThePageToWhomItMay) {
  const ViewState state;
  const ViewServer server({.port = 0, .token = "secret"}, state, [](const std::string&) {});
  const std::string port = PortOf(server);
  EXPECT_EQ(server.url(), "http://127.0.0.1:" + port + "/?token=secret");
  const WebAnswer page = Get(port, "/?token=secret", "127.0.0.1:" + port);
  EXPECT_EQ(page.status, 200U);
  EXPECT_EQ(page.body, ViewPage());
  EXPECT_EQ(page.policy.substr(0, 19), "default-src 'none';");
  EXPECT_EQ(Get(port, "/", "127.0.0.1:" + port).status, 403U);
  EXPECT_EQ(Get(port, "/other?token=secret", "127.0.0.1:" + port).status, 404U);
  EXPECT_THROW(WebClient(port, "/stream"), boost::system::system_error);
  EXPECT_THROW(WebClient(port, "/stream?token=secret", "http://elsewhere.org"),
               boost::system::system_error);
}

TEST(ViewServerTest, APageGetsWhatHappensAndAsksForThings) {
  ViewState state;
  std::atomic<int> pauses = 0;
  ViewServer server({.port = 0}, state,
                    [&](const std::string& command) { pauses += command == "pause" ? 1 : 0; });
  state.SetStatus("first");
  auto client = std::make_unique<WebClient>(PortOf(server), "/stream");
  EXPECT_EQ(client->Receive(10s).value_or("").substr(4), "first");
  state.SetStatus("second");
  server.Wake();
  EXPECT_EQ(client->Receive(10s).value_or("").substr(4), "second");
  EXPECT_EQ(server.viewers(), 1);
  client->Send("pause");
  WaitFor([&] { return pauses == 1; });
  client.reset();
  WaitFor([&] { return server.viewers() == 0; });
}

TEST(ViewServerTest, APageThatStandsStillHoldsNobodyUp) {
  ViewState state;
  ViewServer server({.port = 0}, state, [](const std::string&) {});
  const WebClient still(PortOf(server), "/stream");  // It never reads.
  WebClient reads(PortOf(server), "/stream");
  WaitFor([&] { return server.viewers() == 2; });
  const std::vector<uint8_t> image(500'000);
  for (int i = 0; i < 200; ++i) {  // A hundred megabytes, more than any socket takes.
    state.SetImage(std::to_string(i), image);
    server.Wake();
  }
  std::string newest;
  while (newest.substr(0, 3) != "199") {
    const std::optional<std::string> message = reads.Receive(10s);
    ASSERT_TRUE(message);
    newest = message->substr(8, 3);
  }
}

TEST(ViewServerTest, AnAddressThatIsTakenIsNamed) {
  const ViewState state;
  const ViewServer server({.port = 0}, state, [](const std::string&) {});
  const auto port = static_cast<uint16_t>(std::stoi(PortOf(server)));
  EXPECT_NE(MessageOf([&] {
              const ViewServer other({.port = port}, state, [](const std::string&) {});
            }).find("cannot be listened at"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::apps
