// Ticks a tree with BehaviorTree.CPP 4.10 and logs it in every way: `writer TREE.xml NAME TICKS [kill] [every MS]
// [show PORT]` appends to NAME.btlog, NAME.db3 and NAME.txt. The last one is what a logger inside the program heard: a
// line for each transition, with its time in microseconds since 1970, the number of the node and that of its status.
// With `kill`, the program kills itself after the last tick; `every` says how long it waits after each tick, and with
// `show`, it waits for a line, and Groot2 can connect to it.
//
// A leaf <Scripted answers="rrsf"/> gives one answer at each tick: running, success, failure, skipped, or an exception
// (x); then it begins again. Built with: c++ -std=c++17 writer.cpp -lbehaviortree_cpp
#include <behaviortree_cpp/bt_factory.h>
#include <behaviortree_cpp/loggers/bt_file_logger_v2.h>
#include <behaviortree_cpp/loggers/bt_sqlite_logger.h>
#include <behaviortree_cpp/loggers/groot2_publisher.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <thread>
#include <unistd.h>

using namespace BT;

class Scripted : public StatefulActionNode {
public:
  using StatefulActionNode::StatefulActionNode;
  static PortsList providedPorts() { return {InputPort<std::string>("answers")}; }
  NodeStatus onStart() override { return answer(); }
  NodeStatus onRunning() override { return answer(); }
  void onHalted() override {}

private:
  NodeStatus answer() {
    const auto answers = getInput<std::string>("answers").value();
    switch (answers[next_++ % answers.size()]) {
      case 'r': return NodeStatus::RUNNING;
      case 's': return NodeStatus::SUCCESS;
      case 'f': return NodeStatus::FAILURE;
      case 'x': throw RuntimeError("as scripted");
      default: return NodeStatus::SKIPPED;
    }
  }
  size_t next_ = 0;
};

class Listener : public StatusChangeLogger {
public:
  Listener(const Tree& tree, std::ofstream& file) : StatusChangeLogger(tree.rootNode()), file_(file) {
    enableTransitionToIdle(true);
  }
  void flush() override { file_.flush(); }
  void callback(Duration at, const TreeNode& node, NodeStatus, NodeStatus status) override {
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(at).count();
    file_ << us << ' ' << node.UID() << ' ' << static_cast<int>(status) << std::endl;
  }

private:
  std::ofstream& file_;
};

int main(int count, char** words) {
  BehaviorTreeFactory factory;
  factory.registerNodeType<Scripted>("Scripted");
  auto tree = factory.createTreeFromFile(std::filesystem::absolute(words[1]));
  const std::string name = words[2];
  bool is_killed = false;
  int every_ms = 20, port = 0;
  for (int word = 4; word < count; ++word) {
    const std::string option = words[word];
    if (option == "kill") is_killed = true;
    if (option == "every") every_ms = std::atoi(words[word + 1]);
    if (option == "show") port = std::atoi(words[word + 1]);
  }
  std::ofstream heard(name + ".txt", std::ios::app);
  heard << "session" << std::endl;
  FileLogger2 file(tree, name + ".btlog");
  SqliteLogger sqlite(tree, name + ".db3", true);
  Listener listener(tree, heard);
  std::unique_ptr<Groot2Publisher> publisher;
  if (port) {
    publisher = std::make_unique<Groot2Publisher>(tree, port);
    std::getchar();
  }
  for (int tick = 0; tick < std::atoi(words[3]); ++tick) {
    tree.tickOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(every_ms));
  }
  if (is_killed) {
    kill(getpid(), SIGKILL);
  }
  tree.haltTree();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
}
