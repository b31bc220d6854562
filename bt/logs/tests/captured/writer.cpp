// Ticks a tree with BehaviorTree.CPP 4.10 and logs it in every way: `writer TREE.xml NAME TICKS [kill]` appends to
// NAME.btlog, NAME.db3 and NAME.txt. The last one is what a logger inside the program heard: a line for each
// transition, with its time in microseconds since 1970, the number of the node and that of its status. With `kill`, the
// program kills itself after the last tick.
//
// A leaf <Scripted answers="rrsf"/> gives one answer at each tick: running, success, failure or skipped; then it begins
// again. Built with: c++ -std=c++17 writer.cpp -lbehaviortree_cpp
#include <behaviortree_cpp/bt_factory.h>
#include <behaviortree_cpp/loggers/bt_file_logger_v2.h>
#include <behaviortree_cpp/loggers/bt_sqlite_logger.h>

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
  std::ofstream heard(name + ".txt", std::ios::app);
  heard << "session" << std::endl;
  FileLogger2 file(tree, name + ".btlog");
  SqliteLogger sqlite(tree, name + ".db3", true);
  Listener listener(tree, heard);
  for (int tick = 0; tick < std::atoi(words[3]); ++tick) {
    tree.tickOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  if (count > 4) {
    kill(getpid(), SIGKILL);
  }
  tree.haltTree();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
}
