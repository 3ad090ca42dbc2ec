import { render } from 'preact';
import { listen } from './api/events';
import { App } from './app';
import { listenToKeys } from './keys';
import { followLinks } from './router';
import { loadSession } from './session';
import './styles.css';

followLinks();
listenToKeys();
render(<App />, document.getElementById('app')!);
void loadSession().then(listen, listen);
