#!/usr/bin/env -S nvim --headless --clean -u
-- Uses `steward lsp` from Neovim (0.7 or later): STEWARD=steward FOLDER=folder nvim --headless --clean -u neovim.lua
local steward, folder = vim.env.STEWARD, vim.env.FOLDER

local function fail(message)
  io.stderr:write('Neovim: ' .. message .. '\n')
  vim.cmd('cquit 1')
end

local function await(what, condition)
  if not vim.wait(30000, condition, 20) then fail('no ' .. what) end
end

local function run()
  vim.fn.system({ steward, 'init', folder .. '/app' })
  vim.cmd('edit ' .. folder .. '/app/battery_fault.toml')
  local buffer = vim.api.nvim_get_current_buf()
  local client = vim.lsp.start_client({ name = 'steward', cmd = { steward, 'lsp' }, root_dir = folder })
  vim.lsp.buf_attach_client(buffer, client)
  await('connection', function() return vim.lsp.buf_is_attached(buffer, client) end)
  local function problems() return #vim.diagnostic.get(buffer) end
  vim.api.nvim_buf_set_lines(buffer, -1, -1, true, { '', '[noise.odometry]', 'wrong = "ä𝄞"' })
  await('problem', function() return problems() == 1 end)
  local last = vim.api.nvim_buf_line_count(buffer)
  assert(vim.diagnostic.get(buffer)[1].lnum == last - 1, 'the problem is in another line')
  vim.api.nvim_buf_set_text(buffer, last - 1, 0, last - 1, #'wrong = "ä𝄞"', { '' })
  await('correction', function() return problems() == 0 end)
  local params = { textDocument = { uri = vim.uri_from_bufnr(buffer) }, position = { line = last - 1, character = 0 } }
  local answers = vim.lsp.buf_request_sync(buffer, 'textDocument/completion', params, 30000)
  local items = answers and answers[client] and answers[client].result or {}
  assert(#items > 0, 'no key is proposed')
  vim.lsp.stop_client(client)
  await('end', function() return vim.lsp.client_is_stopped(client) end)
  print('Neovim: a problem came and went, ' .. #items .. ' proposed keys\n')
end

local is_well, message = pcall(run)
if not is_well then fail(tostring(message)) end
vim.cmd('qall!')
