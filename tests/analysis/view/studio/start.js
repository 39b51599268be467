// Starts Foxglove Studio from its library @foxglove/studio-base, which has no page of its own.
const settings = new Map([
  ["colorScheme", "dark"],
  ["hideSignInPrompt", true],
  ["ui.open-dialog-startup", false],
]);
const appConfiguration = {
  get: (key) => settings.get(key),
  set: async (key, value) => void settings.set(key, value),
  addChangeListener: () => {},
  removeChangeListener: () => {},
};

class Layouts {
  spaces = new Map();
  space(name) {
    if (!this.spaces.has(name)) this.spaces.set(name, new Map());
    return this.spaces.get(name);
  }
  list = async (name) => [...this.space(name).values()];
  get = async (name, id) => this.space(name).get(id);
  put = async (name, layout) => (this.space(name).set(layout.id, layout), layout);
  delete = async (name, id) => void this.space(name).delete(id);
  importLayouts = async () => {};
}

// The dialog of the system, which no page can click: it gives the file that its caller accepts.
window.showOpenFilePicker = async (options) => {
  const name = JSON.stringify(options).includes(".mcap") ? "run.mcap" : "foxglove-layout.json";
  const file = new File([await (await fetch(`files/${name}`)).blob()], name);
  class Handle {
    kind = "file";
    name = name;
    async getFile() { return file; }
    async queryPermission() { return "granted"; }
  }
  return [new Handle()];
};

await self.initI18n();
ReactDOM.render(
  React.createElement(self.App, {
    deepLinks: [location.href],
    appConfiguration,
    dataSources: [new self.McapLocalDataSourceFactory(), new self.FoxgloveWebSocketDataSourceFactory()],
    layoutStorage: new Layouts(),
    extensionLoaders: [],
    enableGlobalCss: true,
  }),
  document.getElementById("root"),
);
