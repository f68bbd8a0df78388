#include "view_server.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "gluevo/nn/error.h"
#include "view_page.h"

namespace gluevo::apps {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Tcp = asio::ip::tcp;

constexpr int kMostPages = 16;
constexpr std::size_t kLongestCommand = 64;

std::string_view View(beast::string_view text) { return {text.data(), text.size()}; }

// What all connections of a server share. All of it is used by the server's thread only, but for
// the counter.
struct Shared {
  const ViewAddress& address;
  const ViewState& state;
  const std::function<void(const std::string&)>& command;
  std::atomic<int> viewers = 0;
};

// One connection: a request for the page, or a page that looks.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Tcp::socket socket, Shared& shared) : stream_(std::move(socket)), shared_(shared) {}
  ~Connection() { shared_.viewers -= is_looking_ ? 1 : 0; }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void Start() {
    constexpr auto kPatience = std::chrono::seconds(10);
    beast::get_lowest_layer(stream_).expires_after(kPatience);
    http::async_read(stream_.next_layer(), buffer_, request_,
                     [self = shared_from_this()](error_code error, std::size_t) {
                       if (!error) {
                         self->Answer();
                       }
                     });
  }

  // Sends what the page does not have, a message at a time.
  void SendNext() {
    if (!is_looking_ || message_ != nullptr) {
      return;
    }
    message_ = shared_.state.Next(cursor_);
    if (message_ == nullptr) {
      return;
    }
    stream_.async_write(asio::buffer(*message_),
                        [self = shared_from_this()](error_code error, std::size_t) {
                          self->message_.reset();
                          if (!error) {
                            self->SendNext();
                          }
                        });
  }

 private:
  void Answer() {
    if (!IsOwnRequest(shared_.address, View(request_[http::field::host]),
                      View(request_[http::field::origin]), View(request_.target()))) {
      Reply(http::status::forbidden, "not allowed: the address of the view is printed by gluevo");
    } else if (websocket::is_upgrade(request_)) {
      if (shared_.viewers >= kMostPages) {
        Reply(http::status::service_unavailable, "too many pages look");
      } else {
        Accept();
      }
    } else if (request_.method() != http::verb::get) {
      Reply(http::status::method_not_allowed, "only GET");
    } else if (request_.target() == "/" || request_.target().starts_with("/?")) {
      Reply(http::status::ok, std::string(ViewPage()));
    } else {
      Reply(http::status::not_found, "there is only /");
    }
  }

  void Reply(http::status status, std::string body) {
    auto response = std::make_shared<http::response<http::string_body>>(status, 11);
    response->set(http::field::content_type,
                  status == http::status::ok ? "text/html; charset=utf-8" : "text/plain");
    response->set(http::field::cache_control, "no-store");
    response->set("Content-Security-Policy",
                  "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                  "img-src blob: data:; connect-src 'self'; frame-ancestors 'none'");
    response->keep_alive(false);
    response->body() = std::move(body);
    response->prepare_payload();
    http::async_write(stream_.next_layer(), *response,
                      [self = shared_from_this(), response](error_code, std::size_t) {
                        error_code ignored;
                        beast::get_lowest_layer(self->stream_)
                            .socket()
                            .shutdown(Tcp::socket::shutdown_send, ignored);
                      });
  }

  void Accept() {
    beast::get_lowest_layer(stream_).expires_never();
    // A page that is gone without a word is noticed by its silence.
    stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    stream_.read_message_max(kLongestCommand);
    stream_.binary(true);
    stream_.async_accept(request_, [self = shared_from_this()](error_code error) {
      if (error) {
        return;
      }
      self->is_looking_ = true;
      ++self->shared_.viewers;
      self->buffer_.consume(self->buffer_.size());
      self->Listen();
      self->SendNext();
    });
  }

  void Listen() {
    stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) {
        self->Leave();
        return;
      }
      self->shared_.command(beast::buffers_to_string(self->buffer_.data()));
      self->buffer_.consume(self->buffer_.size());
      self->Listen();
    });
  }

  void Leave() { shared_.viewers -= std::exchange(is_looking_, false) ? 1 : 0; }

  websocket::stream<beast::tcp_stream> stream_;
  Shared& shared_;
  beast::flat_buffer buffer_;
  http::request<http::empty_body> request_;
  ViewState::Cursor cursor_;
  ViewState::Message message_;  // Under way.
  bool is_looking_ = false;
};

Tcp::acceptor Open(asio::io_context& context, const ViewAddress& address) {
  const std::string name = address.host + ":" + std::to_string(address.port);
  error_code error;
  Tcp::resolver resolver(context);
  const auto found = resolver.resolve(address.host, "", error);
  if (error || found.empty()) {
    throw Error("--view " + name + ": no such address: " + error.message());
  }
  Tcp::endpoint endpoint = found.begin()->endpoint();
  endpoint.port(address.port);
  Tcp::acceptor acceptor(context);
  acceptor.open(endpoint.protocol(), error);
  if (!error) {
    acceptor.set_option(asio::socket_base::reuse_address(true), error);
    acceptor.bind(endpoint, error);
  }
  if (!error) {
    acceptor.listen(asio::socket_base::max_listen_connections, error);
  }
  if (error) {
    throw Error("--view " + name + ": cannot be listened at: " + error.message());
  }
  return acceptor;
}

}  // namespace

class ViewServer::Server {
 public:
  Server(ViewAddress address, const ViewState& state,
         std::function<void(const std::string&)> command)
      : address_(std::move(address)),
        command_(std::move(command)),
        shared_{address_, state, command_},
        acceptor_(Open(context_, address_)) {
    address_.port = acceptor_.local_endpoint().port();
    AcceptNext();
    thread_ = std::jthread([this] { context_.run(); });
  }
  ~Server() {
    context_.stop();
    thread_.join();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::string url() const {
    return "http://" + address_.NameForOthers() + ":" + std::to_string(address_.port) + "/" +
           (address_.token.empty() ? "" : "?token=" + address_.token);
  }
  int viewers() const { return shared_.viewers; }

  void Wake() {
    if (viewers() > 0 && !is_woken_.exchange(true)) {
      asio::post(context_, [this] {
        is_woken_ = false;
        std::erase_if(connections_, [](const auto& one) { return one.expired(); });
        for (const std::weak_ptr<Connection>& one : connections_) {
          if (const std::shared_ptr<Connection> connection = one.lock()) {
            connection->SendNext();
          }
        }
      });
    }
  }

 private:
  void AcceptNext() {
    acceptor_.async_accept([this](error_code error, Tcp::socket socket) {
      if (!error) {
        std::erase_if(connections_, [](const auto& one) { return one.expired(); });
        const auto connection = std::make_shared<Connection>(std::move(socket), shared_);
        connections_.push_back(connection);
        connection->Start();
      }
      if (acceptor_.is_open()) {
        AcceptNext();
      }
    });
  }

  ViewAddress address_;
  std::function<void(const std::string&)> command_;
  Shared shared_;
  std::vector<std::weak_ptr<Connection>> connections_;
  std::atomic<bool> is_woken_ = false;
  asio::io_context context_{1};  // After what its handlers use.
  Tcp::acceptor acceptor_;
  std::jthread thread_;
};

ViewServer::ViewServer(const ViewAddress& address, const ViewState& state,
                       std::function<void(const std::string&)> command)
    : server_(std::make_unique<Server>(address, state, std::move(command))) {}

ViewServer::~ViewServer() = default;

std::string ViewServer::url() const { return server_->url(); }

int ViewServer::viewers() const { return server_->viewers(); }

void ViewServer::Wake() { server_->Wake(); }

}  // namespace gluevo::apps
