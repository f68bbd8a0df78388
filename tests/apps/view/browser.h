#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "temporary_folder.h"
#include "web_client.h"

namespace gluevo::apps {

/// A headless Chromium with one page, driven by its protocol for developers' tools.
class Browser {
 public:
  static bool IsThere() { return std::system("command -v chromium >/dev/null 2>&1") == 0; }

  Browser() {
    const std::string log = (folder_.path() / "log").string();
    const std::string profile = "--user-data-dir=" + (folder_.path() / "profile").string();
    pid_ = fork();
    if (pid_ == 0) {
      setpgid(0, 0);
      const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      dup2(output, STDOUT_FILENO);
      dup2(output, STDERR_FILENO);
      execlp("chromium", "chromium", "--headless=new", "--no-sandbox", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "--no-first-run",
             "--remote-debugging-port=0", "--window-size=1280,860", profile.c_str(), "about:blank",
             nullptr);
      _exit(127);
    }
    const std::string address = Announced(log);
    const std::size_t colon = address.find(':', 5);
    const std::size_t slash = address.find('/', colon);
    tools_ = std::make_unique<WebClient>(address.substr(colon + 1, slash - colon - 1),
                                         address.substr(slash));
    const std::string target =
        Call("Target.createTarget", {{"url", "about:blank"}}).at("targetId").get<std::string>();
    session_ = Call("Target.attachToTarget", {{"targetId", target}, {"flatten", true}})
                   .at("sessionId")
                   .get<std::string>();
    Call("Network.enable", nlohmann::json::object());
  }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;
  ~Browser() {
    tools_.reset();
    kill(-pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

  void Open(const std::string& url) { Call("Page.navigate", {{"url", url}}); }

  /// The value of a JavaScript expression.
  nlohmann::json Evaluate(const std::string& expression) {
    const nlohmann::json answer =
        Call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}});
    return answer.at("result").value("value", nlohmann::json());
  }

  /// Whether the expression becomes true within a minute.
  bool Becomes(const std::string& expression) {
    for (int i = 0; i < 600; ++i) {
      if (Evaluate(expression) == nlohmann::json(true)) {
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }

  /// What the page has asked for so far.
  const std::set<std::string>& requests() const { return requests_; }

 private:
  static std::string Announced(const std::string& log) {
    for (int i = 0; i < 600; ++i) {
      std::ifstream lines(log);
      for (std::string line; std::getline(lines, line);) {
        const std::size_t address = line.find("ws://");
        if (line.starts_with("DevTools listening on ") && address != std::string::npos) {
          return line.substr(address);
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    throw std::runtime_error("chromium does not start");
  }

  nlohmann::json Call(const std::string& method, const nlohmann::json& parameters) {
    nlohmann::json call = {{"id", ++calls_}, {"method", method}, {"params", parameters}};
    if (!session_.empty()) {
      call["sessionId"] = session_;
    }
    tools_->Send(call.dump());
    while (const std::optional<std::string> text = tools_->Receive(std::chrono::seconds(60))) {
      const nlohmann::json message = nlohmann::json::parse(*text);
      const std::string event = message.value("method", "");
      if (event == "Network.requestWillBeSent") {
        requests_.insert(message["params"]["request"]["url"].get<std::string>());
      } else if (event == "Network.webSocketCreated") {
        requests_.insert(message["params"]["url"].get<std::string>());
      }
      if (message.value("id", 0) == calls_) {
        return message.at("result");
      }
    }
    throw std::runtime_error("chromium does not answer " + method);
  }

  TemporaryFolder folder_;
  pid_t pid_ = 0;
  std::unique_ptr<WebClient> tools_;
  std::string session_;
  int calls_ = 0;
  std::set<std::string> requests_;
};

}  // namespace gluevo::apps
